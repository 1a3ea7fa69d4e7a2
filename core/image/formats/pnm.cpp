#include "core/image/formats/pnm.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <limits>

namespace sheaf {

namespace {

constexpr const char* kNoPnmHeader = "expected a width, a height and a largest value in the header";

bool is_pnm_space(int c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

/// Skips white space and comments, which reach from # to the end of the line.
void skip_pnm_space(ImageStream& stream) {
  for (int c = stream.peek(); is_pnm_space(c) || c == '#'; c = stream.peek()) {
    if (c == '#')
      while (c >= 0 && c != '\n') c = stream.get();
    else
      (void)stream.get();
  }
}

/// Reads a number, clamped to `max`. Returns -1 if the stream does not continue with a number.
int read_pnm_number(ImageStream& stream, int max = std::numeric_limits<int>::max()) {
  skip_pnm_space(stream);
  std::int64_t number = -1;
  for (int c = stream.peek(); c >= '0' && c <= '9'; c = stream.peek())
    number = std::min<std::int64_t>(10 * std::max<std::int64_t>(number, 0) + (stream.get() - '0'), max);
  return static_cast<int>(number);
}

/// Reads a finite number. Returns 0 for anything else.
float read_pnm_float(ImageStream& stream) {
  constexpr std::size_t kMaxLength = 40;
  skip_pnm_space(stream);
  std::string word;
  while (word.size() < kMaxLength && stream.peek() > ' ') word += static_cast<char>(stream.get());
  float number = 0;
  std::from_chars(word.data() + (word.starts_with('+') ? 1 : 0), word.data() + word.size(), number);
  return std::isfinite(number) ? number : 0.0f;
}

/// Skips the white space after the header of a binary file: one character.
bool skip_one_space(ImageStream& stream) { return is_pnm_space(stream.get()); }

/// Bits, or integers up to a largest value.
class PnmReader final : public IntegerReader {
 public:
  explicit PnmReader(ImageSource source) : stream_(std::move(source)) {}

  bool open(std::string& problem) {
    (void)stream_.get();
    const int type = stream_.get() - '0';
    is_text_ = type <= 3;
    is_bilevel_ = type == 1 || type == 4;
    const int width = read_pnm_number(stream_), height = read_pnm_number(stream_);
    max_ = is_bilevel_ ? 1 : read_pnm_number(stream_);
    if (width < 0 || height < 0 || max_ < 1 || max_ > 65535 || !skip_one_space(stream_)) {
      problem = kNoPnmHeader;
      return false;
    }
    set_header(width, height, default_channel_names(type == 3 || type == 6 ? 3 : 1), max_ > 255 ? 16 : 8);
    return true;
  }

 private:
  bool decode(unsigned char* out, std::string& /*problem*/) override {
    if (max_ > 255) return decode_values(reinterpret_cast<std::uint16_t*>(out));
    return is_bilevel_ && !is_text_ ? decode_bits(out) : decode_values(out);
  }

  template <class Integer> bool decode_values(Integer* out) {
    constexpr std::int64_t kFull = std::numeric_limits<Integer>::max();
    const std::size_t count =
        static_cast<std::size_t>(header_.width) * static_cast<std::size_t>(header_.height) * header_.channels.size();
    for (std::size_t i = 0; i < count; ++i) {
      const int value = is_text_ ? read_text() : read_binary(sizeof(Integer));
      if (value < 0) return false;
      const std::int64_t scaled = std::min(value, max_) * kFull / max_;
      out[i] = static_cast<Integer>(is_bilevel_ ? kFull - scaled : scaled);
    }
    return true;
  }

  int read_text() {
    if (!is_bilevel_) return read_pnm_number(stream_, max_);
    skip_pnm_space(stream_);  // bits need no space between them
    const int digit = stream_.get();
    return digit == '0' || digit == '1' ? digit - '0' : -1;
  }

  /// Reads a number in big-endian order.
  int read_binary(std::size_t bytes) {
    const int first = stream_.get();
    if (bytes == 1 || first < 0) return first;
    const int second = stream_.get();
    return second < 0 ? -1 : first << 8 | second;
  }

  /// Rows of bits, padded to bytes. 1 is black.
  bool decode_bits(unsigned char* out) {
    const auto width = static_cast<std::size_t>(header_.width);
    std::vector<unsigned char> row((width + 7) / 8);
    for (int y = 0; y < header_.height; ++y, out += width) {
      if (!stream_.read(row)) return false;
      for (std::size_t x = 0; x < width; ++x) out[x] = (row[x / 8] >> (7 - x % 8) & 1) != 0 ? 0 : 255;
    }
    return true;
  }

  ImageStream stream_;
  bool is_text_ = false, is_bilevel_ = false;
  int max_ = 0;  ///< largest value
};

/// Rows of floats, from the bottom.
class PfmReader final : public ImageReader {
 public:
  explicit PfmReader(ImageSource source) : stream_(std::move(source)) {}

  bool open(std::string& problem) {
    (void)stream_.get();
    const bool has_colors = stream_.get() == 'F';
    const int width = read_pnm_number(stream_), height = read_pnm_number(stream_);
    scale_ = read_pnm_float(stream_);
    if (width < 0 || height < 0 || scale_ == 0 || !skip_one_space(stream_)) {
      problem = "expected a width, a height and a scale in the header";
      return false;
    }
    set_header(width, height, default_channel_names(has_colors ? 3 : 1));
    return true;
  }

  bool read(float* out, std::string& /*problem*/) override {
    const auto order = scale_ < 0 ? std::endian::little : std::endian::big;
    const std::size_t row = static_cast<std::size_t>(header_.width) * header_.channels.size();
    for (int y = header_.height - 1; y >= 0; --y) {
      float* const values = out + static_cast<std::size_t>(y) * row;
      unsigned char* const bytes = reinterpret_cast<unsigned char*>(values);
      if (!stream_.read({bytes, row * sizeof(float)})) return false;
      for (std::size_t i = 0; i < row; ++i) {
        if (order != std::endian::native) std::reverse(bytes + 4 * i, bytes + 4 * i + 4);
        values[i] *= std::abs(scale_);
      }
    }
    return true;
  }

 private:
  ImageStream stream_;
  float scale_ = 1;  ///< negative for little-endian values
};

}  // namespace

std::unique_ptr<ImageReader> open_pnm(ImageSource source, std::string& problem) {
  auto reader = std::make_unique<PnmReader>(std::move(source));
  if (!reader->open(problem)) return nullptr;
  return reader;
}

std::unique_ptr<ImageReader> open_pfm(ImageSource source, std::string& problem) {
  auto reader = std::make_unique<PfmReader>(std::move(source));
  if (!reader->open(problem)) return nullptr;
  return reader;
}

}  // namespace sheaf
