// Headers are those of the "BITMAPINFOHEADER" family in the Windows documentation; all numbers are little-endian.
#include "core/image/formats/bmp.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdlib>
#include <limits>

namespace sheaf {

namespace {

class BmpReader final : public IntegerReader {
 public:
  explicit BmpReader(ImageSource source) : stream_(std::move(source)) {}

  bool open(std::string& problem) {
    std::array<unsigned char, kFileHeader + kMaxHeader> head{};
    const auto read_size = static_cast<std::size_t>(std::min<std::uint64_t>(head.size(), stream_.size()));
    stream_.read({head.data(), read_size});
    const auto number = [&](std::size_t at, std::size_t bytes) { return little_endian_number({&head[at], bytes}); };
    pixels_at_ = number(10, 4);
    const std::uint32_t header_size = number(kFileHeader, 4);
    const bool is_old = header_size == 12;  // OS/2: sizes of 16 bits
    if (!is_old && header_size != 40 && header_size != 52 && header_size != 56 && header_size != 108 &&
        header_size != 124) {
      problem = fmt::format("unknown BMP header of {} bytes", header_size);
      return false;
    }
    const auto side = [&](std::size_t axis) -> std::int64_t {
      if (is_old) return number(18 + 2 * axis, 2);
      return static_cast<std::int32_t>(number(18 + 4 * axis, 4));
    };
    const std::int64_t width = side(0), height = side(1);
    bits_ = static_cast<int>(is_old ? number(24, 2) : number(28, 2));
    compression_ = is_old ? kUncompressed : number(30, 4);
    if (bits_ == 32) masks_ = {0xff0000, 0xff00, 0xff, 0xff000000};
    if (compression_ == kMasks)
      for (std::size_t c = 0; c < 4; ++c) masks_[c] = c < 3 || header_size >= 56 ? number(54 + 4 * c, 4) : masks_[3];
    is_top_down_ = height < 0;
    if (!has_known_encoding(problem)) return false;
    if (bits_ <= 8 && !read_palette(kFileHeader + header_size, is_old ? 3 : 4, is_old ? 0 : number(46, 4))) {
      problem = kImageEndsEarly;
      return false;
    }
    std::vector<std::string> names = default_channel_names(bits_ == 32 ? 4 : 3);
    if (bits_ == 8 && has_gray_palette()) names = {"Y"};
    const auto clamped = [](std::int64_t pixels) {
      return static_cast<int>(std::clamp<std::int64_t>(pixels, 0, std::numeric_limits<int>::max()));
    };
    set_header(clamped(width), clamped(std::abs(height)), std::move(names), 8);
    return true;
  }

 private:
  static constexpr std::size_t kFileHeader = 14, kMaxHeader = 124;
  static constexpr std::uint32_t kUncompressed = 0, kRunLength8 = 1, kRunLength4 = 2, kMasks = 3;

  bool has_known_encoding(std::string& problem) const {
    const bool is_known = bits_ == 1 || bits_ == 4 || bits_ == 8 || bits_ == 16 || bits_ == 24 || bits_ == 32;
    const bool is_plain = compression_ == kUncompressed || (compression_ == kMasks && bits_ >= 16);
    if (compression_ == kMasks && (masks_[0] == 0 || masks_[1] == 0 || masks_[2] == 0)) {
      problem = "a BMP color without bits";
      return false;
    }
    if (is_known && (is_plain || (is_run_length() && bits_ == (compression_ == kRunLength8 ? 8 : 4)))) return true;
    problem = fmt::format("unknown BMP encoding: compression {} with {} bits per pixel", compression_, bits_);
    return false;
  }

  bool is_run_length() const { return compression_ == kRunLength8 || compression_ == kRunLength4; }

  bool read_palette(std::uint64_t at, std::size_t entry_bytes, std::uint32_t count) {
    const std::uint32_t max_count = 1u << bits_;
    if (count > max_count) return false;
    palette_.resize(count == 0 ? max_count : count);
    stream_.seek(at);
    for (std::array<unsigned char, 4>& color : palette_)
      if (!stream_.read({color.data(), entry_bytes})) return false;
    return true;
  }

  bool has_gray_palette() const {
    return std::all_of(palette_.begin(), palette_.end(),
                       [](const auto& color) { return color[0] == color[1] && color[1] == color[2]; });
  }

  bool decode(unsigned char* out, std::string& /*problem*/) override {
    stream_.seek(pixels_at_);
    return is_run_length() ? decode_runs(out) : decode_rows(out);
  }

  std::size_t row_offset(std::size_t file_row) const {
    const auto height = static_cast<std::size_t>(header_.height), width = static_cast<std::size_t>(header_.width);
    return (is_top_down_ && !is_run_length() ? file_row : height - 1 - file_row) * width * header_.channels.size();
  }

  bool decode_rows(unsigned char* out) {
    const auto width = static_cast<std::size_t>(header_.width);
    std::vector<unsigned char> row((width * static_cast<std::size_t>(bits_) + 31) / 32 * 4);
    for (std::size_t y = 0; y < static_cast<std::size_t>(header_.height); ++y) {
      if (!stream_.read(row)) return false;
      unsigned char* pixel = out + row_offset(y);
      for (std::size_t x = 0; x < width; ++x, pixel += header_.channels.size()) put_pixel(row.data(), x, pixel);
    }
    return true;
  }

  void put_pixel(const unsigned char* row, std::size_t x, unsigned char* pixel) const {
    if (bits_ <= 8) {
      const std::size_t in_byte = 8 / static_cast<std::size_t>(bits_),
                        shift = 8 - (x % in_byte + 1) * static_cast<std::size_t>(bits_);
      put_color(row[x / in_byte] >> shift & ((1u << bits_) - 1), pixel);
    } else if (bits_ == 24) {
      for (std::size_t c = 0; c < 3; ++c) pixel[c] = row[3 * x + 2 - c];
    } else {
      const auto bytes = static_cast<std::size_t>(bits_ / 8);
      const std::uint32_t value = little_endian_number({row + bytes * x, bytes});
      for (std::size_t c = 0; c < header_.channels.size(); ++c) pixel[c] = masked(value, masks_[c]);
    }
  }

  void put_color(std::size_t index, unsigned char* pixel) const {
    const auto& color = palette_[std::min(index, palette_.size() - 1)];
    for (std::size_t c = 0; c < header_.channels.size(); ++c) pixel[c] = color[2 - c];
  }

  /// The bits under a mask, repeated up to 8 bits. Without bits, alpha is opaque.
  static unsigned char masked(std::uint32_t value, std::uint32_t mask) {
    if (mask == 0) return 255;
    const int low = std::countr_zero(mask), count = std::countr_one(mask >> low);
    const std::uint32_t bits = (value & mask) >> low;
    std::uint32_t result = 0;
    int shift = 8 - count;
    for (; shift > 0; shift -= count) result |= bits << shift;
    return static_cast<unsigned char>(result | bits >> -shift);
  }

  /// Pairs of a count and an index, or of 0 and an operation. Pixels that no pair reaches have index 0.
  bool decode_runs(unsigned char* out) {
    const auto width = static_cast<std::size_t>(header_.width), height = static_cast<std::size_t>(header_.height);
    for (std::size_t i = 0; i < width * height; ++i) put_color(0, out + i * header_.channels.size());
    std::size_t x = 0, y = 0;
    const auto put = [&](int index) {
      if (x < width) put_color(static_cast<std::size_t>(index), out + row_offset(y) + x * header_.channels.size());
      ++x;
    };
    for (;;) {
      std::array<unsigned char, 2> pair{};
      if (!stream_.read(pair)) return false;
      const auto [count, value] = pair;
      if (count == 0 && value == 1) return true;  // end of the image
      if (y >= height) return false;
      if (count > 0) {
        for (int i = 0; i < count; ++i) put(nibble(value, i));
      } else if (value == 0) {  // end of the row
        x = 0;
        ++y;
      } else if (value == 2) {  // moves ahead
        std::array<unsigned char, 2> step{};
        if (!stream_.read(step)) return false;
        x += step[0];
        y += step[1];
      } else if (!put_literal(value, put)) {
        return false;
      }
    }
  }

  /// Reads `count` indices, padded to 16 bits.
  template <class Put> bool put_literal(std::size_t count, const Put& put) {
    const std::size_t in_byte = compression_ == kRunLength4 ? 2 : 1;
    std::array<unsigned char, 256> indices{};
    if (!stream_.read({indices.data(), ((count + in_byte - 1) / in_byte + 1) / 2 * 2})) return false;
    for (std::size_t i = 0; i < count; ++i) put(nibble(indices[i / in_byte], static_cast<int>(i)));
    return true;
  }

  /// The index of the i-th of a run of pixels: with 4 bits, the two indices of a byte alternate.
  int nibble(int byte, int i) const {
    if (compression_ == kRunLength8) return byte;
    return i % 2 == 0 ? byte >> 4 : byte & 15;
  }

  ImageStream stream_;
  std::uint64_t pixels_at_ = 0;
  int bits_ = 0;  ///< per pixel
  std::uint32_t compression_ = kUncompressed;
  bool is_top_down_ = false;
  std::array<std::uint32_t, 4> masks_{0x7c00, 0x3e0, 0x1f, 0};  ///< of red, green, blue and alpha in 16 or 32 bits
  std::vector<std::array<unsigned char, 4>> palette_;           ///< blue, green and red
};

}  // namespace

std::unique_ptr<ImageReader> open_bmp(ImageSource source, std::string& problem) {
  auto reader = std::make_unique<BmpReader>(std::move(source));
  if (!reader->open(problem)) return nullptr;
  return reader;
}

}  // namespace sheaf
