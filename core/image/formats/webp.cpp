// The only file that includes libwebp.
#include "core/image/formats/webp.h"

#include <webp/decode.h>
#include <webp/demux.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

namespace sheaf {

namespace {

class WebpReader final : public IntegerReader {
 public:
  explicit WebpReader(ImageSource source) : source_(std::move(source)) {}

  /// Reads size and alpha from the first chunk.
  bool open(std::string& problem) {
    constexpr std::size_t kData = 20;
    constexpr std::uint32_t k14Bits = 0x3fff, kLosslessAlpha = 1u << 28, kExtendedAlpha = 0x10;
    std::array<unsigned char, 30> head{};
    source_.read(0, head);
    const std::string_view file(reinterpret_cast<const char*>(head.data()), kData), chunk = file.substr(12, 4);
    const auto number = [&](std::size_t at, std::size_t bytes) {
      return little_endian_number({&head[kData + at], bytes});
    };
    std::uint32_t width = 0, height = 0;
    bool has_alpha = false;
    if (chunk == "VP8 ") {
      width = number(6, 2) & k14Bits, height = number(8, 2) & k14Bits;
    } else if (chunk == "VP8L") {
      const std::uint32_t bits = number(1, 4);
      width = (bits & k14Bits) + 1, height = (bits >> 14 & k14Bits) + 1;
      has_alpha = (bits & kLosslessAlpha) != 0;
    } else if (chunk == "VP8X") {
      width = number(4, 3) + 1, height = number(7, 3) + 1;
      has_alpha = (number(0, 1) & kExtendedAlpha) != 0;
    }
    if (!file.starts_with("RIFF") || width == 0) {
      problem = "the WebP header is damaged";
      return false;
    }
    riff_size_ = 8 + std::uint64_t{little_endian_number({&head[4], 4})};
    set_header(static_cast<int>(width), static_cast<int>(height), default_channel_names(has_alpha ? 4 : 3), 8);
    header_.decoder_bytes = 2;  // 4 bytes per pixel
    return true;
  }

 private:
  bool decode(unsigned char* out, std::string& problem) override {
    problem = kImageEndsEarly;
    std::vector<unsigned char> bytes;
    if (source_.memory() == nullptr) {
      bytes.resize(static_cast<std::size_t>(std::min(source_.size(), riff_size_)));
      if (!source_.read(0, bytes)) return false;
    }
    const std::vector<unsigned char>& all = source_.memory() == nullptr ? bytes : source_.memory()->bytes;
    const WebPData data{all.data(), all.size()};
    const std::unique_ptr<WebPDemuxer, decltype(&WebPDemuxDelete)> file(WebPDemux(&data), WebPDemuxDelete);
    if (!file) return false;
    const bool has_alpha = (WebPDemuxGetI(file.get(), WEBP_FF_FORMAT_FLAGS) & ALPHA_FLAG) != 0;
    if (WebPDemuxGetI(file.get(), WEBP_FF_CANVAS_WIDTH) != static_cast<std::uint32_t>(header_.width) ||
        WebPDemuxGetI(file.get(), WEBP_FF_CANVAS_HEIGHT) != static_cast<std::uint32_t>(header_.height) ||
        has_alpha != (header_.channels.size() == 4))
      return false;
    WebPIterator frame{};
    if (WebPDemuxGetFrame(file.get(), 1, &frame) == 0) return false;
    const bool is_complete = decode_frame(frame, out);
    WebPDemuxReleaseIterator(&frame);
    return is_complete;
  }

  /// Decodes a frame, which may cover a part of the image.
  bool decode_frame(const WebPIterator& frame, unsigned char* out) const {
    const auto width = static_cast<std::size_t>(header_.width), height = static_cast<std::size_t>(header_.height);
    const std::size_t channels = header_.channels.size(), row_bytes = width * channels, size = row_bytes * height;
    std::fill_n(out, size, static_cast<unsigned char>(0));
    const std::size_t at =
        static_cast<std::size_t>(frame.y_offset) * row_bytes + static_cast<std::size_t>(frame.x_offset) * channels;
    if (at >= size) return false;
    const auto decode_into = channels == 4 ? WebPDecodeRGBAInto : WebPDecodeRGBInto;
    return decode_into(frame.fragment.bytes, frame.fragment.size, out + at, size - at, static_cast<int>(row_bytes)) !=
           nullptr;
  }

  ImageSource source_;
  std::uint64_t riff_size_ = 0;  ///< bytes that the header claims
};

}  // namespace

std::unique_ptr<ImageReader> open_webp(ImageSource source, std::string& problem) {
  auto reader = std::make_unique<WebpReader>(std::move(source));
  if (!reader->open(problem)) return nullptr;
  return reader;
}

std::string webp_version() {
  const int version = WebPGetDecoderVersion();
  return fmt::format("{}.{}.{}", version >> 16, version >> 8 & 255, version & 255);
}

}  // namespace sheaf
