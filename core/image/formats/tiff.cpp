#include "core/image/formats/tiff.h"

#include "core/image/formats/tiff_file.h"
#include "core/math/half.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <string_view>
#include <type_traits>

namespace sheaf {

namespace {

template <class Value> Value value_at(const unsigned char* values, std::size_t i) {
  Value value;
  std::memcpy(&value, values + i * sizeof(Value), sizeof(Value));
  return value;
}

/// The i-th of packed integers of `bits` bits, highest bit first.
std::uint32_t packed_at(const unsigned char* values, std::size_t i, std::size_t bits) {
  std::uint32_t value = 0;
  for (std::size_t at = i * bits, end = at + bits; at < end; ++at)
    value = value << 1 | (static_cast<std::uint32_t>(values[at / 8]) >> (7 - at % 8) & 1);
  return value;
}

/// An integer as a value: a byte, or a float relative to the largest integer.
template <class Value, class Integer> Value to_value(Integer integer) {
  if constexpr (std::is_same_v<Value, float>)
    return static_cast<float>(integer) * (1.0f / static_cast<float>(std::numeric_limits<Integer>::max()));
  else
    return static_cast<Value>(integer);
}

/// Passes the bytes of an image file to libtiff.
class TiffInput {
 public:
  explicit TiffInput(ImageSource source) : source_(std::move(source)) {}

  static tmsize_t read(thandle_t file, void* out, tmsize_t size) {
    TiffInput& input = *static_cast<TiffInput*>(file);
    if (size <= 0 || input.at_ >= input.source_.size()) return 0;
    const auto count = std::min(static_cast<std::uint64_t>(size), input.source_.size() - input.at_);
    if (!input.source_.read(input.at_, {static_cast<unsigned char*>(out), static_cast<std::size_t>(count)})) return 0;
    input.at_ += count;
    return static_cast<tmsize_t>(count);
  }
  static tmsize_t write(thandle_t, void*, tmsize_t) { return 0; }
  static toff_t seek(thandle_t file, toff_t offset, int origin) {
    TiffInput& input = *static_cast<TiffInput*>(file);
    const std::uint64_t from = origin == SEEK_CUR ? input.at_ : origin == SEEK_END ? input.source_.size() : 0;
    return input.at_ = from + offset;
  }
  static toff_t size(thandle_t file) { return static_cast<TiffInput*>(file)->source_.size(); }

 private:
  ImageSource source_;
  std::uint64_t at_ = 0;
};

class TiffReader final : public ImageReader {
 public:
  explicit TiffReader(ImageSource source) : input_(std::move(source)) {}

  bool open(std::string& problem) {
    file_ = open_tiff_file(input_, message_, "rm");  // m: no memory mapping
    if (file_ && !read_layout(problem)) return false;
    if (!file_) problem = message_.text().empty() ? "the file is damaged" : message_.text();
    return file_ != nullptr;
  }

  bool read(std::uint8_t* out, std::string& problem) override { return read_all(out, problem); }
  bool read(float* out, std::string& problem) override { return read_all(out, problem); }

 private:
  /// Kinds of samples with as many bits as the type, or fewer.
  enum class Samples { kPacked8, kPacked16, kUint8, kUint16, kUint32, kInt8, kInt16, kInt32, kHalf, kFloat, kDouble };

  template <class Value> Value field(std::uint32_t tag, Value default_value = {}) {
    Value value = default_value;
    return TIFFGetFieldDefaulted(file_.get(), tag, &value) == 1 ? value : default_value;
  }

  bool read_layout(std::string& problem) {
    bits_ = field<std::uint16_t>(TIFFTAG_BITSPERSAMPLE, 1);
    samples_ = field<std::uint16_t>(TIFFTAG_SAMPLESPERPIXEL, 1);
    photometric_ = samples_ == 1 ? PHOTOMETRIC_MINISBLACK : PHOTOMETRIC_RGB;
    photometric_ = field<std::uint16_t>(TIFFTAG_PHOTOMETRIC, photometric_);
    is_separate_ = field<std::uint16_t>(TIFFTAG_PLANARCONFIG) == PLANARCONFIG_SEPARATE && samples_ > 1;
    is_cmyk_ = photometric_ == PHOTOMETRIC_SEPARATED && samples_ == 4 &&
               field<std::uint16_t>(TIFFTAG_INKSET, INKSET_CMYK) == INKSET_CMYK;
    has_palette_ = photometric_ == PHOTOMETRIC_PALETTE;
    uses_rgba_ = needs_rgba();
    const char* const unsupported = uses_rgba_ ? unsupported_by_rgba() : unsupported_samples();
    if (unsupported != nullptr) {
      problem =
          fmt::format("{} in a TIFF file of {} bits per sample and {} samples per pixel", unsupported, bits_, samples_);
      return false;
    }
    const auto side = [&](std::uint32_t tag) {
      return static_cast<int>(std::min<std::uint32_t>(field<std::uint32_t>(tag), std::numeric_limits<int>::max()));
    };
    set_header(side(TIFFTAG_IMAGEWIDTH), side(TIFFTAG_IMAGELENGTH), channel_names());
    header_.holds_bytes = uses_rgba_ || has_palette_ || kind_ == Samples::kPacked8 || kind_ == Samples::kUint8;
    header_.holds_integers = header_.holds_bytes || kind_ < Samples::kHalf;
    header_.orientation = field<std::uint16_t>(TIFFTAG_ORIENTATION, 1);  // libtiff replaces unknown ones
    if (TIFFIsTiled(file_.get()) != 0) {
      header_.tile_width = std::max(side(TIFFTAG_TILEWIDTH), 1);
      header_.tile_height = std::max(side(TIFFTAG_TILELENGTH), 1);
    }
    if (uses_rgba_) header_.decoder_bytes = 2 * sizeof(std::uint32_t);  // the image, and a strip or tile of any height
    return true;
  }

  /// Whether libtiff converts the colors.
  bool needs_rgba() const {
    switch (photometric_) {
      case PHOTOMETRIC_YCBCR:
      case PHOTOMETRIC_CIELAB:
      case PHOTOMETRIC_ICCLAB:
      case PHOTOMETRIC_ITULAB:
      case PHOTOMETRIC_LOGL:
      case PHOTOMETRIC_LOGLUV:
        return true;
      default:
        return false;
    }
  }

  /// What prevents libtiff from converting the colors; null if nothing does.
  const char* unsupported_by_rgba() {
    char message[1024];
    if (TIFFRGBAImageOK(file_.get(), message) == 0 || samples_ > 4) return "unsupported colors";
    return nullptr;
  }

  /// What prevents reading samples as they are; null if nothing does. Sets `kind_` and reads the palette.
  const char* unsupported_samples() {
    const auto format = field<std::uint16_t>(TIFFTAG_SAMPLEFORMAT, SAMPLEFORMAT_UINT);
    if (!find_kind(format)) return "unsupported samples";
    if (field<std::uint32_t>(TIFFTAG_IMAGEDEPTH, 1) > 1 || field<std::uint32_t>(TIFFTAG_TILEDEPTH, 1) > 1)
      return "volumes are not supported:";
    const bool is_integer = kind_ == Samples::kPacked8 || kind_ == Samples::kUint8 || kind_ == Samples::kUint16;
    if (is_cmyk_ && (!is_integer || bits_ < 8)) return "unsupported CMYK samples";
    if (has_palette_ && (!is_integer || samples_ != 1 || !read_palette())) return "unsupported palette";
    return nullptr;
  }

  /// Finds the kind of samples; `format` is the tag SampleFormat. Returns whether it is supported.
  bool find_kind(std::uint16_t format) {
    const bool is_unsigned = format == SAMPLEFORMAT_UINT, is_signed = format == SAMPLEFORMAT_INT,
               is_float = format == SAMPLEFORMAT_IEEEFP;
    switch (bits_) {
      case 8:
        kind_ = is_signed ? Samples::kInt8 : Samples::kUint8;
        return !is_float;
      case 16:
        kind_ = is_unsigned ? Samples::kUint16 : is_signed ? Samples::kInt16 : Samples::kHalf;
        return is_unsigned || is_signed || is_float;
      case 32:
        kind_ = is_unsigned ? Samples::kUint32 : is_signed ? Samples::kInt32 : Samples::kFloat;
        return is_unsigned || is_signed || is_float;
      case 64:
        kind_ = Samples::kDouble;
        return is_float;
      default:
        kind_ = bits_ < 8 ? Samples::kPacked8 : Samples::kPacked16;
        return is_unsigned && bits_ < 16;
    }
  }

  bool read_palette() {
    std::uint16_t *red = nullptr, *green = nullptr, *blue = nullptr;
    if (TIFFGetField(file_.get(), TIFFTAG_COLORMAP, &red, &green, &blue) != 1) return false;
    for (std::size_t i = 0; i < std::size_t{1} << bits_; ++i)
      for (const std::uint16_t* const color : {red, green, blue})
        palette_.push_back(static_cast<std::uint8_t>(color[i] / 257));
    return true;
  }

  std::vector<std::string> channel_names() {
    if (is_cmyk_ || has_palette_) return {"R", "G", "B"};
    std::vector<std::string> names = default_channel_names(samples_);
    if (photometric_ == PHOTOMETRIC_SEPARATED) {
      for (std::size_t c = 0; c < names.size(); ++c) names[c] = fmt::format("ink{}", c);
      return names;
    }
    std::uint16_t count = 0, *kinds = nullptr;
    if (TIFFGetField(file_.get(), TIFFTAG_EXTRASAMPLES, &count, &kinds) != 1) return names;
    const bool is_gray = photometric_ == PHOTOMETRIC_MINISWHITE || photometric_ == PHOTOMETRIC_MINISBLACK ||
                         photometric_ == PHOTOMETRIC_MASK;
    std::size_t alpha = names.size();
    for (std::size_t i = 0, c = is_gray ? 1 : 3; i < count && c < names.size(); ++i, ++c) {
      if (kinds[i] != EXTRASAMPLE_UNSPECIFIED)
        alpha = c;
      else if (names[c] == "A")
        names[c] = fmt::format("channel{}", c);
    }
    if (alpha < names.size()) names[alpha] = "A";
    if (names.size() == 2 && alpha == 1) names[0] = "Y";
    return names;
  }

  template <class Value> bool read_all(Value* out, std::string& problem) {
    message_.clear();
    const bool is_complete = uses_rgba_                      ? read_rgba(out)
                             : TIFFIsTiled(file_.get()) != 0 ? read_tiles(out)
                                                             : read_rows(out);
    if (!is_complete && !message_.text().empty()) problem = message_.text();
    return is_complete;
  }

  /// Whether `size` bytes hold `columns` pixels of the samples that are stored together.
  bool holds(tmsize_t size, std::size_t columns) const {
    const std::size_t bits = columns * (is_separate_ ? 1 : samples_) * bits_;
    return size > 0 && static_cast<std::size_t>(size) >= (bits + 7) / 8;
  }

  template <class Value> bool read_rows(Value* out) {
    const auto width = static_cast<std::size_t>(header_.width);
    const tmsize_t size = TIFFScanlineSize(file_.get());
    if (!holds(size, width)) return false;
    std::vector<unsigned char> row(static_cast<std::size_t>(size));
    // Plane by plane, because compressed strips can only be read in order
    for (std::uint16_t plane = 0; plane < (is_separate_ ? samples_ : 1); ++plane)
      for (int y = 0; y < header_.height; ++y) {
        if (TIFFReadScanline(file_.get(), row.data(), static_cast<std::uint32_t>(y), plane) < 0) return false;
        put_row(row.data(), width, plane, out + static_cast<std::size_t>(y) * width * header_.channels.size());
      }
    return true;
  }

  template <class Value> bool read_tiles(Value* out) {
    const std::size_t width = static_cast<std::size_t>(header_.width),
                      height = static_cast<std::size_t>(header_.height),
                      tile_width = static_cast<std::size_t>(header_.tile_width),
                      tile_height = static_cast<std::size_t>(header_.tile_height);
    const tmsize_t size = TIFFTileSize(file_.get()), row_size = TIFFTileRowSize(file_.get());
    if (!holds(row_size, tile_width) ||
        static_cast<std::size_t>(size) / tile_height < static_cast<std::size_t>(row_size))
      return false;
    std::vector<unsigned char> tile(static_cast<std::size_t>(size));
    for (std::uint16_t plane = 0; plane < (is_separate_ ? samples_ : 1); ++plane)
      for (std::size_t y0 = 0; y0 < height; y0 += tile_height)
        for (std::size_t x0 = 0; x0 < width; x0 += tile_width) {
          if (TIFFReadTile(file_.get(), tile.data(), static_cast<std::uint32_t>(x0), static_cast<std::uint32_t>(y0), 0,
                           plane) < 0)
            return false;
          const std::size_t columns = std::min(tile_width, width - x0), rows = std::min(tile_height, height - y0);
          for (std::size_t y = 0; y < rows; ++y)
            put_row(tile.data() + y * static_cast<std::size_t>(row_size), columns, plane,
                    out + ((y0 + y) * width + x0) * header_.channels.size());
        }
    return true;
  }

  template <class Value> bool read_rgba(Value* out) {
    const auto width = static_cast<std::uint32_t>(header_.width), height = static_cast<std::uint32_t>(header_.height);
    std::vector<std::uint32_t> pixels(static_cast<std::size_t>(width) * height);
    // In the orientation of the file, which libtiff keeps then
    if (TIFFReadRGBAImageOriented(file_.get(), width, height, pixels.data(), header_.orientation, 1) == 0) return false;
    for (const std::uint32_t pixel : pixels)
      for (std::size_t c = 0; c < header_.channels.size(); ++c)
        *out++ = to_value<Value>(static_cast<std::uint8_t>(pixel >> 8 * c));
    return true;
  }

  /// Converts the stored samples of a row of pixels: all of them, or one plane.
  template <class Value>
  void put_row(const unsigned char* row, std::size_t columns, std::size_t plane, Value* out) const {
    const auto put = [&](auto sample_at) { put_samples(sample_at, columns, plane, out); };
    const auto integers = [&](auto integer_at) {
      using Integer = decltype(integer_at(0));
      const bool inverts = photometric_ == PHOTOMETRIC_MINISWHITE;
      put([=](std::size_t i) {
        const Integer integer = integer_at(i);
        return to_value<Value>(inverts ? static_cast<Integer>(std::numeric_limits<Integer>::max() - integer) : integer);
      });
    };
    const std::uint32_t highest = bits_ < 16 ? (1u << bits_) - 1 : 1;  // of packed integers
    if (has_palette_) return put_colors(row, columns, out);
    switch (kind_) {
      case Samples::kPacked8:
        return integers(
            [=, this](std::size_t i) { return static_cast<std::uint8_t>(packed_at(row, i, bits_) * 255 / highest); });
      case Samples::kPacked16:
        return integers([=, this](std::size_t i) {
          return static_cast<std::uint16_t>(packed_at(row, i, bits_) * 65535 / highest);
        });
      case Samples::kUint8:
        return integers([=](std::size_t i) { return row[i]; });
      case Samples::kUint16:
        return integers([=](std::size_t i) { return value_at<std::uint16_t>(row, i); });
      case Samples::kUint32:
        return integers([=](std::size_t i) { return value_at<std::uint32_t>(row, i); });
      case Samples::kInt8:
        return put([=](std::size_t i) { return to_value<Value>(value_at<std::int8_t>(row, i)); });
      case Samples::kInt16:
        return put([=](std::size_t i) { return to_value<Value>(value_at<std::int16_t>(row, i)); });
      case Samples::kInt32:
        return put([=](std::size_t i) { return to_value<Value>(value_at<std::int32_t>(row, i)); });
      case Samples::kHalf:
        return put([=](std::size_t i) { return static_cast<Value>(half_to_float(value_at<std::uint16_t>(row, i))); });
      case Samples::kFloat:
        return put([=](std::size_t i) { return static_cast<Value>(value_at<float>(row, i)); });
      case Samples::kDouble:
        return put([=](std::size_t i) { return static_cast<Value>(value_at<double>(row, i)); });
    }
  }

  template <class Value, class SampleAt>
  void put_samples(SampleAt sample_at, std::size_t columns, std::size_t plane, Value* out) const {
    const std::size_t channels = header_.channels.size();
    if (is_separate_) {
      for (std::size_t x = 0; x < columns; ++x) put_channel(out + x * channels, plane, sample_at(x));
    } else if (is_cmyk_) {
      for (std::size_t i = 0; i < columns * samples_; ++i)
        put_channel(out + i / samples_ * channels, i % samples_, sample_at(i));
    } else {
      for (std::size_t i = 0; i < columns * samples_; ++i) out[i] = sample_at(i);
    }
  }

  template <class Value> void put_channel(Value* pixel, std::size_t channel, Value value) const {
    if (!is_cmyk_ || channel < 3) {
      pixel[channel] = value;
      return;
    }
    // Black comes last: the product of what ink and black leave
    constexpr float kScale = std::is_same_v<Value, float> ? 1.0f : 1.0f / 255;
    const float levels = bits_ == 16 ? 65535.0f : 255.0f;
    for (std::size_t c = 0; c < 3; ++c) {
      const float left = (1.0f - static_cast<float>(pixel[c]) * kScale) * (1.0f - static_cast<float>(value) * kScale);
      const float level = std::floor(left * levels + 0.5f);
      pixel[c] = static_cast<Value>(std::is_same_v<Value, float> ? level * (1.0f / levels) : level);
    }
  }

  template <class Value> void put_colors(const unsigned char* row, std::size_t columns, Value* out) const {
    for (std::size_t x = 0; x < columns; ++x) {
      const std::size_t index = bits_ == 16 ? value_at<std::uint16_t>(row, x) : packed_at(row, x, bits_);
      for (std::size_t c = 0; c < 3; ++c) *out++ = to_value<Value>(palette_[3 * index + c]);
    }
  }

  TiffInput input_;
  TiffMessage message_;
  TiffHandle file_{nullptr, TIFFClose};
  std::uint16_t bits_ = 0, samples_ = 0;  ///< per sample, and per pixel
  std::uint16_t photometric_ = 0;
  bool is_separate_ = false;  ///< each sample of a pixel has its own plane
  bool is_cmyk_ = false, has_palette_ = false;
  bool uses_rgba_ = false;  ///< libtiff converts to RGBA of 8 bits
  Samples kind_ = Samples::kUint8;
  std::vector<std::uint8_t> palette_;  ///< red, green and blue
};

}  // namespace

std::unique_ptr<ImageReader> open_tiff(ImageSource source, std::string& problem) {
  auto reader = std::make_unique<TiffReader>(std::move(source));
  if (!reader->open(problem)) return nullptr;
  return reader;
}

std::string tiff_version() {
  std::string_view text = TIFFGetVersion();  // "LIBTIFF, Version 4.5.0", and lines on copyright
  text = text.substr(0, text.find('\n'));
  return std::string(text.substr(text.rfind(' ') + 1));
}

}  // namespace sheaf
