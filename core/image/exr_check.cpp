// A parser of OpenEXR headers (Academy Software Foundation, "OpenEXR File Layout"). A file begins with a magic number
// and a version with flags. A header is a list of attributes that ends with an empty name. An attribute has a name, a
// type, the size of its value, and the value. In multi-part files headers follow each other, and an empty header ends
// the list.
#include "core/image/exr_check.h"

#include "core/io/error.h"

#include <fmt/format.h>

#include <cstdint>
#include <fstream>
#include <string>
#include <string_view>

namespace sheaf {

namespace {

struct TypeSize {
  std::string_view type;
  std::int32_t bytes;
};

/// Types of fixed size. The library reads their values by type and ignores the size in the file.
constexpr TypeSize kSizes[] = {{"box2f", 16},      {"box2i", 16},   {"chromaticities", 32},
                               {"compression", 1}, {"double", 8},   {"envmap", 1},
                               {"float", 4},       {"int", 4},      {"keycode", 28},
                               {"lineOrder", 1},   {"m33f", 36},    {"m33d", 72},
                               {"m44f", 64},       {"m44d", 128},   {"rational", 8},
                               {"tiledesc", 9},    {"timecode", 8}, {"v2d", 16},
                               {"v2f", 8},         {"v2i", 8},      {"v3d", 24},
                               {"v3f", 12},        {"v3i", 12},     {"deepImageState", 1}};

class HeaderReader {
 public:
  explicit HeaderReader(const std::filesystem::path& file)
      : file_(file.string()),
        stream_(file, std::ios::binary),
        size_(static_cast<std::int64_t>(std::filesystem::file_size(file))) {}

  void check() {
    constexpr std::uint32_t kMultiPart = 0x1000;
    number();
    const bool multi_part = (number() & kMultiPart) != 0;
    for (bool inside = false; std::getline(stream_, name_, '\0');) {
      if (name_.empty() && !(inside && multi_part)) return;  // the end of the header, or of all headers
      inside = !name_.empty();
      if (inside) check_attribute();
    }
  }

 private:
  std::uint32_t number() {
    unsigned char bytes[4] = {};
    stream_.read(reinterpret_cast<char*>(bytes), sizeof bytes);
    return bytes[0] | bytes[1] << 8 | bytes[2] << 16 | std::uint32_t{bytes[3]} << 24;
  }
  /// Offset of the next byte; the size of the file if reading has failed.
  std::int64_t at() { return stream_ ? static_cast<std::int64_t>(stream_.tellg()) : size_; }

  void check_attribute() {
    std::string type;
    std::getline(stream_, type, '\0');
    const auto bytes = static_cast<std::int32_t>(number());
    if (!stream_) return;
    const std::int64_t end = at() + bytes;
    if (bytes < 0 || end > size_) fail();
    for (const TypeSize& known : kSizes)
      if (type == known.type && bytes != known.bytes) fail();
    if (type == "chlist") skip_channels();
    if (type == "preview") skip_preview();
    if (type == "stringvector") skip_strings(end);
    const bool walked = type == "chlist" || type == "preview" || type == "stringvector";
    if (walked && stream_ && at() != end) fail();
    stream_.seekg(end);
  }

  /// Skips channels: a name and 16 bytes each, up to an empty name.
  void skip_channels() {
    for (std::string channel; std::getline(stream_, channel, '\0') && !channel.empty();)
      stream_.seekg(16, std::ios::cur);
  }

  /// Skips a preview image: width, height, and 4 bytes per pixel.
  void skip_preview() {
    const std::uint64_t width = number(), height = number();
    if (width != 0 && height > static_cast<std::uint64_t>(size_) / 4 / width) fail();
    stream_.seekg(static_cast<std::streamoff>(width * height * 4), std::ios::cur);
  }

  /// Skips strings: a length and the characters each.
  void skip_strings(std::int64_t end) {
    while (stream_ && at() < end) {
      const std::uint32_t length = number();
      if (length > end - at()) fail();
      stream_.seekg(length, std::ios::cur);
    }
  }

  [[noreturn]] void fail() const {
    throw SceneError({file_, 0}, fmt::format("the image's header is damaged (impossible size of the attribute '{}')",
                                             name_.substr(0, 60)));
  }

  std::string file_;
  std::ifstream stream_;
  std::int64_t size_;
  std::string name_;  ///< of the attribute being read
};

}  // namespace

void check_exr_headers(const std::filesystem::path& file) { HeaderReader(file).check(); }

}  // namespace sheaf
