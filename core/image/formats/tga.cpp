#include "core/image/formats/tga.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace sheaf {

namespace {

class TgaReader final : public IntegerReader {
 public:
  explicit TgaReader(ImageSource source) : stream_(std::move(source)) {}

  bool open(std::string& problem) {
    std::array<unsigned char, 18> head{};
    if (!stream_.read(head)) {
      problem = kImageEndsEarly;
      return false;
    }
    const auto number = [&](std::size_t at) { return little_endian_number({&head[at], 2}); };
    const int type = head[2], bits = head[16], attributes = head[17];
    is_run_length_ = type >= 8;
    kind_ = static_cast<Kind>(is_run_length_ ? type - 8 : type);
    first_color_ = number(3);
    pixel_bytes_ = static_cast<std::size_t>(bits + 7) / 8;
    color_bytes_ = static_cast<std::size_t>(head[7] + 7) / 8;
    const bool has_palette = head[1] == 1;
    if (head[1] > 1 || !is_known(type, bits, has_palette, head[7])) {
      problem = fmt::format("unknown TGA encoding: type {} with {} bits per pixel", type, bits);
      return false;
    }
    pixels_at_ = head.size() + head[0];
    if (has_palette) {
      palette_.resize(color_bytes_ * number(5));
      stream_.seek(pixels_at_);
      if (!stream_.read(palette_)) {
        problem = kImageEndsEarly;
        return false;
      }
      pixels_at_ += palette_.size();
    }
    std::vector<std::string> names = default_channel_names((kind_ == kPalette ? head[7] : bits) == 32 ? 4 : 3);
    if (kind_ == kGray) names = {"Y"};
    if (kind_ == kGray && bits >= 16 && (attributes & kAlpha) != 0) names.emplace_back("A");
    is_from_right_ = (attributes & kFromRight) != 0;
    is_from_top_ = (attributes & kFromTop) != 0;
    set_header(static_cast<int>(number(12)), static_cast<int>(number(14)), std::move(names), 8);
    return true;
  }

 private:
  enum Kind : int { kPalette = 1, kColor = 2, kGray = 3 };
  static constexpr int kAlpha = 0x08, kFromRight = 0x10, kFromTop = 0x20;

  bool is_known(int type, int bits, bool has_palette, int color_bits) const {
    if (type != kPalette && type != kColor && type != kGray && type != 8 + kPalette && type != 8 + kColor &&
        type != 8 + kGray)
      return false;
    const auto is_color = [](int count) { return count == 15 || count == 16 || count == 24 || count == 32; };
    if (has_palette && !is_color(color_bits)) return false;
    if (kind_ == kPalette) return has_palette && (bits == 8 || bits == 15 || bits == 16);
    return kind_ == kColor ? is_color(bits) : !has_palette && (bits == 8 || bits == 16);
  }

  bool decode(unsigned char* out, std::string& /*problem*/) override {
    stream_.seek(pixels_at_);
    const auto width = static_cast<std::size_t>(header_.width), height = static_cast<std::size_t>(header_.height);
    const std::size_t channels = header_.channels.size();
    std::array<unsigned char, 4> pixel{};
    int left = 0;  // in the packet, which repeats one pixel or has several
    bool repeats = false;
    for (std::size_t y = 0; y < height; ++y) {
      unsigned char* const row = out + (is_from_top_ ? y : height - 1 - y) * width * channels;
      for (std::size_t x = 0; x < width; ++x, --left) {
        const bool begins = left == 0;
        if (begins) {
          const int packet = is_run_length_ ? stream_.get() : 0;
          if (packet < 0) return false;
          left = 1 + (packet & 0x7f);
          repeats = (packet & 0x80) != 0;
        }
        if ((begins || !repeats) && !read_pixel(pixel.data())) return false;
        std::copy_n(pixel.begin(), channels, row + (is_from_right_ ? width - 1 - x : x) * channels);
      }
    }
    return true;
  }

  bool read_pixel(unsigned char* out) {
    std::array<unsigned char, 4> stored{};
    if (!stream_.read({stored.data(), pixel_bytes_})) return false;
    if (kind_ == kGray) {
      std::copy_n(stored.begin(), header_.channels.size(), out);
      return true;
    }
    if (kind_ == kColor) {
      put_color(stored.data(), pixel_bytes_, out);
      return true;
    }
    const std::size_t index = little_endian_number({stored.data(), pixel_bytes_});
    if (index < first_color_ || (index - first_color_ + 1) * color_bytes_ > palette_.size()) return false;
    put_color(&palette_[(index - first_color_) * color_bytes_], color_bytes_, out);
    return true;
  }

  void put_color(const unsigned char* stored, std::size_t bytes, unsigned char* out) const {
    if (bytes > 2) {  // blue, green, red, alpha
      for (std::size_t c = 0; c < 3; ++c) out[c] = stored[2 - c];
      if (header_.channels.size() == 4) out[3] = stored[3];
      return;
    }
    const std::uint32_t bits = little_endian_number({stored, 2});
    for (std::size_t c = 0; c < 3; ++c) {
      const std::uint32_t level = bits >> (10 - 5 * c) & 31;
      out[c] = static_cast<unsigned char>(level << 3 | level >> 2);
    }
  }

  ImageStream stream_;
  Kind kind_ = kColor;
  bool is_run_length_ = false, is_from_right_ = false, is_from_top_ = false;
  std::size_t pixel_bytes_ = 0, color_bytes_ = 0;  ///< per stored pixel, and per color of the palette
  std::uint64_t pixels_at_ = 0;
  std::vector<unsigned char> palette_;
  std::size_t first_color_ = 0;  ///< index of the first color of the palette
};

}  // namespace

std::unique_ptr<ImageReader> open_tga(ImageSource source, std::string& problem) {
  auto reader = std::make_unique<TgaReader>(std::move(source));
  if (!reader->open(problem)) return nullptr;
  return reader;
}

}  // namespace sheaf
