// PLY headers consist of lines that start with format, comment, obj_info, element, property or end_header.
#include "scene/formats/ply_header.h"

#include <algorithm>
#include <array>
#include <charconv>

namespace sheaf {

namespace {

struct TypeName {
  std::string_view name;
  PlyType type;
};
constexpr std::array<TypeName, 16> kTypeNames{{{"char", PlyType::kInt8},
                                               {"int8", PlyType::kInt8},
                                               {"uchar", PlyType::kUint8},
                                               {"uint8", PlyType::kUint8},
                                               {"short", PlyType::kInt16},
                                               {"int16", PlyType::kInt16},
                                               {"ushort", PlyType::kUint16},
                                               {"uint16", PlyType::kUint16},
                                               {"int", PlyType::kInt32},
                                               {"int32", PlyType::kInt32},
                                               {"uint", PlyType::kUint32},
                                               {"uint32", PlyType::kUint32},
                                               {"float", PlyType::kFloat32},
                                               {"float32", PlyType::kFloat32},
                                               {"double", PlyType::kFloat64},
                                               {"float64", PlyType::kFloat64}}};

std::string quote(std::string_view text) {
  constexpr std::size_t kLongest = 40;
  return fmt::format("'{}{}", text.substr(0, kLongest), text.size() > kLongest ? "...'" : "'");
}

std::vector<std::string_view> split_words(std::string_view line) {
  constexpr std::string_view kBlanks = " \t";
  std::vector<std::string_view> words;
  for (std::size_t begin = line.find_first_not_of(kBlanks); begin != std::string_view::npos;) {
    const std::size_t end = std::min(line.find_first_of(kBlanks, begin), line.size());
    words.push_back(line.substr(begin, end - begin));
    begin = line.find_first_not_of(kBlanks, end);
  }
  return words;
}

class HeaderParser {
 public:
  HeaderParser(std::string_view bytes, const std::string& file, std::uint64_t file_bytes)
      : bytes_(bytes), file_(file), file_bytes_(file_bytes) {}

  PlyHeader parse() {
    read_magic();
    bool has_format = false;
    for (;;) {
      const std::string_view line = next_line();
      const std::vector<std::string_view> words = split_words(line);
      // Read comments
      if (words.size() > 2 && words[0] == "comment" && words[1] == "TextureFile" && header_.texture.empty())
        header_.texture = line.substr(static_cast<std::size_t>(words[2].data() - line.data()));
      if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
      if (words[0] == "end_header") break;
      // Read declarations
      if (words[0] == "format") {
        read_format(words);
        has_format = true;
      } else if (words[0] == "element") {
        read_element(words);
      } else if (words[0] == "property") {
        read_property(words);
      } else {
        fail(fmt::format(
            "expected a PLY header line, found {}{}", quote(words[0]),
            did_you_mean(words[0], {"format", "comment", "obj_info", "element", "property", "end_header"})));
      }
    }
    // Check the header
    if (!has_format) fail("the PLY header has no 'format' line");
    header_.size = position_;
    header_.lines = line_;
    check_counts();
    return std::move(header_);
  }

 private:
  [[noreturn]] void fail(const std::string& message) const { throw SceneError(SourceLocation{file_, line_}, message); }

  /// Reads the first line, and detects the line ending: LF, CR LF or CR.
  void read_magic() {
    constexpr std::string_view kMagic = "ply";
    line_ = 1;
    const std::size_t end = bytes_.find_first_of("\r\n");
    const std::string_view start = bytes_.substr(0, std::min<std::size_t>(end, 16));
    if (!start.starts_with(kMagic) || split_words(start).front() != kMagic) {
      fail("expected a PLY file, which begins with 'ply'");
    }
    if (end == std::string_view::npos) fail("the PLY header ends without 'end_header'");
    line_end_ = bytes_[end] == '\r' && bytes_.substr(end + 1, 1) != "\n" ? '\r' : '\n';
    position_ = bytes_.find(line_end_) + 1;
  }

  std::string_view next_line() {
    constexpr std::size_t kLongestHeader = std::size_t{1} << 20;
    const std::size_t end = bytes_.find(line_end_, position_);
    if (end == std::string_view::npos || end > kLongestHeader) fail("the PLY header ends without 'end_header'");
    std::string_view line = bytes_.substr(position_, end - position_);
    if (line.ends_with('\r')) line.remove_suffix(1);
    position_ = end + 1;
    ++line_;
    return line;
  }

  void read_format(const std::vector<std::string_view>& words) {
    using Encoding = PlyHeader::Encoding;
    if (words.size() != 3) fail("expected 'format', an encoding and a version");
    if (words[2] != "1.0") fail("expected version 1.0 of the PLY format, found " + quote(words[2]));
    if (words[1] == "ascii") {
      header_.encoding = Encoding::kAscii;
    } else if (words[1] == "binary_little_endian") {
      header_.encoding = Encoding::kLittleEndian;
    } else if (words[1] == "binary_big_endian") {
      header_.encoding = Encoding::kBigEndian;
    } else {
      fail(fmt::format("unknown PLY encoding {}{}", quote(words[1]),
                       did_you_mean(words[1], {"ascii", "binary_little_endian", "binary_big_endian"})));
    }
  }

  void read_element(const std::vector<std::string_view>& words) {
    if (words.size() != 3) fail("expected 'element', a name and a count");
    PlyElement element{std::string(words[1]), 0, {}};
    const auto [end, failure] = std::from_chars(words[2].data(), words[2].data() + words[2].size(), element.count);
    if (failure != std::errc{} || end != words[2].data() + words[2].size()) {
      fail(fmt::format("expected the number of rows of element {}, found {}", quote(words[1]), quote(words[2])));
    }
    for (const PlyElement& other : header_.elements) {
      if (other.name == element.name) fail(fmt::format("element {} appears twice", quote(words[1])));
    }
    header_.elements.push_back(std::move(element));
  }

  void read_property(const std::vector<std::string_view>& words) {
    if (header_.elements.empty()) fail("a property before the first element");
    const bool is_list = words.size() > 1 && words[1] == "list";
    if (words.size() != (is_list ? 5u : 3u)) fail("expected 'property TYPE NAME' or 'property list TYPE TYPE NAME'");
    PlyProperty property{std::string(words.back()), type_named(words[words.size() - 2]), {}};
    if (is_list) {
      property.count_type = type_named(words[2]);
      if (property.count_type == PlyType::kFloat32 || property.count_type == PlyType::kFloat64) {
        fail(fmt::format("expected an integer type for the length of list {}, found {}", quote(words.back()),
                         quote(words[2])));
      }
    }
    header_.elements.back().properties.push_back(std::move(property));
  }

  PlyType type_named(std::string_view name) const {
    std::vector<std::string> names;
    for (const TypeName& known : kTypeNames) {
      if (known.name == name) return known.type;
      names.emplace_back(known.name);
    }
    fail(fmt::format("unknown PLY type {}{}", quote(name), did_you_mean(name, names)));
  }

  /// Returns the minimum size of a row in bytes: empty lists; in ASCII, one digit and one blank per number.
  std::uint64_t smallest_row(const PlyElement& element) const {
    std::uint64_t size = 0;
    for (const PlyProperty& p : element.properties) {
      size += header_.encoding == PlyHeader::Encoding::kAscii ? 2 : ply_type_size(p.count_type.value_or(p.type));
    }
    return size;
  }

  void check_counts() const {
    const std::uint64_t available = file_bytes_ - position_ + 1;  // the final blank may be missing
    for (const PlyElement& element : header_.elements) {
      const std::uint64_t row = smallest_row(element);
      if (row == 0 || element.count <= available / row) continue;
      throw SceneError(
          SourceLocation{file_},
          fmt::format("element {} claims {} rows of at least {} bytes, but only {} bytes follow the header: truncated?",
                      quote(element.name), element.count, row, available - 1));
    }
  }

  std::string_view bytes_;
  const std::string& file_;
  const std::uint64_t file_bytes_;
  PlyHeader header_;
  std::size_t position_ = 0;
  int line_ = 0;
  char line_end_ = '\n';
};

}  // namespace

std::size_t ply_type_size(PlyType type) {
  switch (type) {
    case PlyType::kInt8:
    case PlyType::kUint8:
      return 1;
    case PlyType::kInt16:
    case PlyType::kUint16:
      return 2;
    case PlyType::kFloat64:
      return 8;
    default:
      return 4;
  }
}

PlyHeader parse_ply_header(std::string_view bytes, const std::string& file, std::uint64_t file_bytes) {
  return HeaderParser(bytes, file, std::max<std::uint64_t>(file_bytes, bytes.size())).parse();
}

}  // namespace sheaf
