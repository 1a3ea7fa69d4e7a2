#include "tools/importer/fbx_document.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>
#include <type_traits>

namespace sheaf::importer {

namespace {

constexpr int kMaxDepth = 8;  ///< of elements that are kept

bool is_kept(std::string_view name, int depth) {
  constexpr std::array<std::string_view, 11> kNames = {
      "Definitions",  "ObjectType", "PropertyTemplate", "Objects", "Model", "NodeAttribute", "CollectionExclusive",
      "Properties70", "P",          "Connections",      "C"};
  return depth < kMaxDepth && std::find(kNames.begin(), kNames.end(), name) != kNames.end();
}

FbxValue number_value(double number, std::int64_t integer) { return {{}, number, integer}; }

/// Converts without undefined behavior; numbers out of range become 0.
std::int64_t to_integer(double number) {
  constexpr double kLimit = 9e18;
  return number > -kLimit && number < kLimit ? static_cast<std::int64_t>(number) : 0;
}

/// The binary form: records with the offset of their end.
class BinaryReader {
 public:
  BinaryReader(std::string_view bytes, bool has_long_offsets) : bytes_(bytes), long_(has_long_offsets) {}

  /// Reads the records in [at, end).
  std::vector<FbxElement> elements(std::size_t at, std::size_t end, int depth) const {
    std::vector<FbxElement> out;
    const std::size_t header = long_ ? 25 : 13;
    while (at < end && end - at >= header) {
      const std::uint64_t record_end = offset(at, 0), count = offset(at, 1), size = offset(at, 2);
      const std::size_t name_size = static_cast<unsigned char>(bytes_[at + header - 1]);
      const std::size_t values = at + header + name_size;
      if (record_end <= at || record_end > end || values > record_end || size > record_end - values) break;
      const std::string_view name = bytes_.substr(at + header, name_size);
      at = static_cast<std::size_t>(record_end);
      if (!is_kept(name, depth)) continue;
      FbxElement element{std::string(name), read_values(values, values + size, count), {}};
      element.children = elements(static_cast<std::size_t>(values + size), at, depth + 1);
      out.push_back(std::move(element));
    }
    return out;
  }

 private:
  template <class T> T number(std::size_t at) const {
    T value;
    std::memcpy(&value, bytes_.data() + at, sizeof(T));
    return value;
  }
  std::uint64_t offset(std::size_t at, std::size_t index) const {
    return long_ ? number<std::uint64_t>(at + 8 * index) : number<std::uint32_t>(at + 4 * index);
  }

  /// Reads up to `count` values in [at, end). Arrays become empty values.
  std::vector<FbxValue> read_values(std::size_t at, std::size_t end, std::uint64_t count) const {
    std::vector<FbxValue> out;
    for (; count > 0 && at < end; --count) {
      const char type = bytes_[at++];
      const std::size_t left = end - at;
      std::size_t size = 0;
      const auto read = [&]<class T>(T) {
        size = sizeof(T);
        if (left < size) return;
        const T value = number<T>(at);
        if constexpr (std::is_floating_point_v<T>)
          out.push_back(number_value(value, to_integer(value)));
        else
          out.push_back(number_value(static_cast<double>(value), value));
      };
      switch (type) {
        case 'C':
          read(std::int8_t{});
          break;
        case 'Y':
          read(std::int16_t{});
          break;
        case 'I':
          read(std::int32_t{});
          break;
        case 'L':
          read(std::int64_t{});
          break;
        case 'F':
          read(float{});
          break;
        case 'D':
          read(double{});
          break;
        case 'S':
        case 'R': {
          if (left < 4) return out;
          size = 4 + std::size_t{number<std::uint32_t>(at)};
          if (size <= left) out.push_back({std::string(bytes_.substr(at + 4, size - 4)), 0, 0});
          break;
        }
        default:  // arrays: number of elements, encoding, number of bytes
          if (std::string_view("fdlibc").find(type) == std::string_view::npos || left < 12) return out;
          size = 12 + std::size_t{number<std::uint32_t>(at + 8)};
          out.emplace_back();
      }
      if (size > left) return out;
      at += size;
    }
    return out;
  }

  std::string_view bytes_;
  bool long_;
};

/// The text form: `Name: value, value {` elements `}`.
class TextReader {
 public:
  explicit TextReader(std::string_view bytes) : bytes_(bytes) {}

  /// Reads elements until the end of the block or of the file. Elements of a block that is not kept are skipped.
  std::vector<FbxElement> elements(bool keeps) {
    std::vector<FbxElement> out;
    while (skip_space()) {
      if (bytes_[at_] == '}') {
        ++at_;
        break;
      }
      const std::size_t begin = at_;
      const std::string_view name = word();
      if (!skip_space() || bytes_[at_] != ':') {
        at_ = std::max(at_, begin + 1);
        continue;
      }
      ++at_;
      const bool kept = keeps && is_kept(name, depth_);
      FbxElement element{std::string(kept ? name : std::string_view()), {}, {}};
      read_values(kept ? &element.values : nullptr);
      if (at_ < bytes_.size() && bytes_[at_] == '{') {
        ++at_;
        if (kept) {
          ++depth_;
          element.children = elements(true);
          --depth_;
        } else {
          skip_block();
        }
      }
      if (kept) out.push_back(std::move(element));
    }
    return out;
  }

 private:
  /// Skips white space and comments. Returns false at the end of the file.
  bool skip_space() {
    while (at_ < bytes_.size()) {
      if (bytes_[at_] == ';') {
        at_ = std::min(bytes_.find('\n', at_), bytes_.size());
      } else if (static_cast<unsigned char>(bytes_[at_]) <= ' ') {
        ++at_;
      } else {
        return true;
      }
    }
    return false;
  }

  /// Reads a word, possibly an empty one.
  std::string_view word() {
    const std::size_t begin = at_;
    while (at_ < bytes_.size() && static_cast<unsigned char>(bytes_[at_]) > ' ' &&
           std::string_view(":,{}\";").find(bytes_[at_]) == std::string_view::npos)
      ++at_;
    return bytes_.substr(begin, at_ - begin);
  }

  /// Reads a text in quotation marks.
  std::string_view quoted() {
    const std::size_t begin = at_ + 1, end = std::min(bytes_.find('"', begin), bytes_.size());
    at_ = std::min(end + 1, bytes_.size());
    return bytes_.substr(begin, end - begin);
  }

  /// Reads values until a brace or the name of the next element.
  void read_values(std::vector<FbxValue>* to) {
    while (skip_space()) {
      const char c = bytes_[at_];
      if (c == '{' || c == '}') return;
      if (c == ',') {
        ++at_;
      } else if (c == '"') {
        const std::string_view text = quoted();
        if (to != nullptr) to->push_back({std::string(text), 0, 0});
      } else {
        const std::size_t begin = at_;
        const std::string_view text = word();
        if (text.empty()) ++at_;  // a colon in the wrong place
        if (skip_space() && bytes_[at_] == ':') {
          at_ = begin;
          return;
        }
        if (to == nullptr || text.empty()) continue;
        const std::string terminated(text);
        to->push_back(
            number_value(std::strtod(terminated.c_str(), nullptr), std::strtoll(terminated.c_str(), nullptr, 10)));
        to->back().text = terminated;
      }
    }
  }

  /// Skips to the end of a block.
  void skip_block() {
    for (std::size_t open = 1; open > 0 && skip_space();) {
      const char c = bytes_[at_];
      if (c == '"') {
        quoted();
        continue;
      }
      ++at_;
      if (c == '{') ++open;
      if (c == '}') --open;
    }
  }

  std::string_view bytes_;
  std::size_t at_ = 0;
  int depth_ = 0;
};

}  // namespace

std::vector<FbxElement> read_fbx(std::string_view bytes) {
  constexpr std::size_t kHeader = 27, kVersion = 23;
  if (!bytes.starts_with("Kaydara FBX Binary")) return TextReader(bytes).elements(true);
  if (bytes.size() < kHeader) return {};
  std::uint32_t version = 0;
  std::memcpy(&version, bytes.data() + kVersion, sizeof(version));
  return BinaryReader(bytes, version >= 7500).elements(kHeader, bytes.size(), 0);
}

}  // namespace sheaf::importer
