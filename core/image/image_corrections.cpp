// Parsers of Radiance headers and TIFF directories.
#include "core/image/image_corrections.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <optional>
#include <string_view>

namespace sheaf {

namespace {

namespace fs = std::filesystem;

std::vector<std::uint8_t> read_all(const fs::path& file) {
  std::vector<std::uint8_t> bytes(fs::file_size(file));
  std::ifstream(file, std::ios::binary)
      .read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  return bytes;
}

/// One axis of a resolution string, such as "+X" or "-Y".
struct Axis {
  char sign = 0, name = 0;
};

/// Parses the axes of a resolution string: first the axis from row to row, then the axis along a row.
std::optional<std::array<Axis, 2>> parse_resolution(std::string_view line) {
  std::array<Axis, 2> axes;
  for (Axis& axis : axes) {
    line.remove_prefix(std::min(line.find_first_not_of(" \t"), line.size()));
    if (line.size() < 3 || (line[0] != '+' && line[0] != '-') || (line[1] != 'X' && line[1] != 'Y')) return {};
    axis = {line[0], line[1]};
    line.remove_prefix(2);
    line.remove_prefix(std::min(line.find_first_not_of(" \t"), line.size()));
    const std::size_t digits = std::min(line.find_first_not_of("0123456789"), line.size());
    if (digits == 0) return {};
    line.remove_prefix(digits);
  }
  if (axes[0].name == axes[1].name) return {};
  return axes;
}

/// The TIFF orientation for the axes of a resolution string. X points to the right, Y upwards.
int orientation_of(const std::array<Axis, 2>& axes) {
  const bool columns = axes[0].name == 'X';
  const Axis x = axes[columns ? 0 : 1], y = axes[columns ? 1 : 0];
  const bool from_right = x.sign == '-', from_bottom = y.sign == '+';
  if (columns) return from_right ? (from_bottom ? 7 : 6) : (from_bottom ? 8 : 5);
  return from_right ? (from_bottom ? 3 : 2) : (from_bottom ? 4 : 1);
}

/// Parses the header lines up to an empty line, and the resolution string behind it.
ImageCorrections radiance_corrections(const fs::path& file) {
  constexpr std::size_t kMaxHeader = std::size_t{1} << 16;
  constexpr std::string_view kXyz = "FORMAT=32-bit_rle_xyze", kRgb = "FORMAT=32-bit_rle_rgbe";
  std::string header(std::min<std::size_t>(fs::file_size(file), kMaxHeader), '\0');
  std::ifstream(file, std::ios::binary).read(header.data(), static_cast<std::streamsize>(header.size()));
  ImageCorrections found;
  std::size_t format_at = 0;
  for (std::size_t at = 0; at < header.size();) {
    const std::size_t end = std::min(header.find('\n', at), header.size());
    const std::string_view line(header.data() + at, end - at);
    if (line.starts_with(kXyz)) {
      found.xyz = true;
      format_at = at;
    }
    at = end + 1;
    if (!line.empty() && line != "\r") continue;
    const std::size_t resolution_end = std::min(header.find('\n', at), header.size());
    if (at >= resolution_end) break;
    if (const auto axes = parse_resolution(std::string_view(header).substr(at, resolution_end - at)))
      found.orientation = orientation_of(*axes);
    break;
  }
  // Let the library read XYZE as RGBE: the encoding is the same.
  if (found.xyz) {
    found.bytes = read_all(file);
    std::copy(kRgb.begin(), kRgb.end(), found.bytes.begin() + static_cast<std::ptrdiff_t>(format_at));
  }
  return found;
}

/// The first directory of a TIFF file, of either byte order, with offsets of 32 or of 64 bits.
class TiffDirectory {
 public:
  /// One entry of the directory.
  struct Entry {
    std::uint32_t tag = 0;
    std::uint64_t value = 0;  ///< value field, read as a 16-bit number
    std::size_t at = 0;       ///< offset of the entry in the file
  };

  explicit TiffDirectory(const fs::path& file) : file_(file), stream_(file, std::ios::binary) {
    size_ = fs::file_size(file);
    std::array<std::uint8_t, 2> mark{};
    read(0, mark);
    big_endian_ = mark[0] == 'M';
    is_big_tiff_ = number(2, 2) == 43;
    const std::size_t at = is_big_tiff_ ? number(8, 8) : number(4, 4);
    const std::size_t count_bytes = is_big_tiff_ ? 8 : 2;
    const std::uint64_t count = number(at, count_bytes);
    if (!stream_ || at > size_ || count > kMaxEntries) return;
    for (std::uint64_t i = 0; i < count; ++i) {
      const std::size_t entry_at = at + count_bytes + i * entry_bytes();
      const auto tag = static_cast<std::uint32_t>(number(entry_at, 2));
      entries_.push_back({tag, number(entry_at + (is_big_tiff_ ? 12 : 8), 2), entry_at});
    }
    valid_ = static_cast<bool>(stream_) && !entries_.empty();
  }

  /// Whether the directory is readable. If it is not, the library reports the error.
  bool valid() const { return valid_; }

  const Entry* find(std::uint32_t tag) const {
    for (const Entry& entry : entries_)
      if (entry.tag == tag) return &entry;
    return nullptr;
  }

  /// The data of the file with a new directory at its end that replaces this one. It has one more entry: a 16-bit
  /// number.
  std::vector<std::uint8_t> with_entry(std::uint32_t tag, std::uint32_t value) const {
    std::vector<std::uint8_t> bytes = read_all(file_);
    if (bytes.size() % 2 != 0) bytes.push_back(0);
    put(bytes, is_big_tiff_ ? 8 : 4, bytes.size(), is_big_tiff_ ? 8 : 4);
    append(bytes, entries_.size() + 1, is_big_tiff_ ? 8 : 2);
    bool added = false;
    for (const Entry& entry : entries_) {
      if (!added && entry.tag > tag) append_entry(bytes, tag, value);
      added = added || entry.tag > tag;
      for (std::size_t i = 0; i < entry_bytes(); ++i) bytes.push_back(bytes[entry.at + i]);
    }
    if (!added) append_entry(bytes, tag, value);
    append(bytes, 0, is_big_tiff_ ? 8 : 4);
    return bytes;
  }

 private:
  static constexpr std::uint64_t kMaxEntries = 4096;

  std::size_t entry_bytes() const { return is_big_tiff_ ? 20 : 12; }

  template <class Bytes> void read(std::size_t at, Bytes& bytes) {
    stream_.seekg(static_cast<std::streamoff>(at));
    stream_.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  }
  std::uint64_t number(std::size_t at, std::size_t count) {
    std::array<std::uint8_t, 8> bytes{};
    stream_.seekg(static_cast<std::streamoff>(at));
    stream_.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(count));
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < count; ++i) value |= std::uint64_t{bytes[i]} << 8 * (big_endian_ ? count - 1 - i : i);
    return value;
  }

  void put(std::vector<std::uint8_t>& bytes, std::size_t at, std::uint64_t value, std::size_t count) const {
    for (std::size_t i = 0; i < count; ++i)
      bytes[at + i] = static_cast<std::uint8_t>(value >> 8 * (big_endian_ ? count - 1 - i : i));
  }
  void append(std::vector<std::uint8_t>& bytes, std::uint64_t value, std::size_t count) const {
    bytes.resize(bytes.size() + count);
    put(bytes, bytes.size() - count, value, count);
  }
  /// Appends an entry. Numbers shorter than the value field are stored at its beginning.
  void append_entry(std::vector<std::uint8_t>& bytes, std::uint32_t tag, std::uint32_t value) const {
    constexpr std::uint32_t kShort = 3;
    append(bytes, tag, 2);
    append(bytes, kShort, 2);
    append(bytes, 1, is_big_tiff_ ? 8 : 4);
    append(bytes, value, 2);
    append(bytes, 0, is_big_tiff_ ? 6 : 2);
  }

  fs::path file_;
  std::ifstream stream_;
  std::size_t size_ = 0;
  bool big_endian_ = false, is_big_tiff_ = false, valid_ = false;
  std::vector<Entry> entries_;
};

ImageCorrections tiff_corrections(const fs::path& file) {
  constexpr std::uint32_t kBitsPerSample = 258, kOrientation = 274;
  ImageCorrections found;
  const TiffDirectory directory(file);
  if (!directory.valid()) return found;
  const TiffDirectory::Entry* const orientation = directory.find(kOrientation);
  if (orientation != nullptr && orientation->value >= 1 && orientation->value <= 8)
    found.orientation = static_cast<int>(orientation->value);
  if (directory.find(kBitsPerSample) == nullptr) found.bytes = directory.with_entry(kBitsPerSample, 1);
  return found;
}

}  // namespace

ImageCorrections find_corrections(const fs::path& file, const std::string& format) {
  if (format == "hdr") return radiance_corrections(file);
  if (format == "tiff") return tiff_corrections(file);
  return {};
}

}  // namespace sheaf
