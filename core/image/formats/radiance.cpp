#include "core/image/formats/radiance.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>

namespace sheaf {

namespace {

/// One axis of a resolution string, such as "+X 512".
struct Axis {
  char sign = 0, name = 0;
  int size = 0;  ///< pixels
};

/// Parses a resolution string: first the axis from row to row, then the axis along a row.
std::optional<std::array<Axis, 2>> parse_resolution(std::string_view line) {
  std::array<Axis, 2> axes;
  for (Axis& axis : axes) {
    line.remove_prefix(std::min(line.find_first_not_of(" \t"), line.size()));
    if (line.size() < 3 || (line[0] != '+' && line[0] != '-') || (line[1] != 'X' && line[1] != 'Y')) return {};
    axis = {line[0], line[1], 0};
    line.remove_prefix(2);
    line.remove_prefix(std::min(line.find_first_not_of(" \t"), line.size()));
    const auto [end, error] = std::from_chars(line.data(), line.data() + line.size(), axis.size);
    if (error != std::errc()) return {};
    line.remove_prefix(static_cast<std::size_t>(end - line.data()));
  }
  if (axes[0].name == axes[1].name) return {};
  return axes;
}

/// The orientation for the axes of a resolution string; see ImageHeader. X points to the right, Y upwards.
int orientation_of(const std::array<Axis, 2>& axes) {
  const bool columns = axes[0].name == 'X';
  const Axis x = axes[columns ? 0 : 1], y = axes[columns ? 1 : 0];
  const bool from_right = x.sign == '-', from_bottom = y.sign == '+';
  if (columns) return from_right ? (from_bottom ? 7 : 6) : (from_bottom ? 8 : 5);
  return from_right ? (from_bottom ? 3 : 2) : (from_bottom ? 4 : 1);
}

class RadianceReader final : public ImageReader {
 public:
  explicit RadianceReader(ImageSource source) : stream_(std::move(source)) {}

  /// Reads the header: lines up to an empty one, and the resolution string.
  bool open(std::string& problem) {
    bool has_format = false;
    for (std::string line = read_line(); !line.empty(); line = read_line()) {
      if (line == "FORMAT=32-bit_rle_xyze") header_.xyz = true;
      has_format = has_format || line == "FORMAT=32-bit_rle_rgbe" || line == "FORMAT=32-bit_rle_xyze";
    }
    if (!has_format) {
      problem = "expected FORMAT=32-bit_rle_rgbe or FORMAT=32-bit_rle_xyze in the header";
      return false;
    }
    const auto axes = parse_resolution(read_line());
    if (!axes) {
      problem = "expected a resolution such as '-Y 512 +X 1024' after the header";
      return false;
    }
    set_header((*axes)[1].size, (*axes)[0].size, {"R", "G", "B"});
    header_.orientation = orientation_of(*axes);
    return true;
  }

  bool read(float* out, std::string& /*problem*/) override {
    const auto width = static_cast<std::size_t>(header_.width);
    std::vector<unsigned char> row(4 * width);
    for (int y = 0; y < header_.height; ++y) {
      // Runs are stored per component; other pixels follow each other
      bool has_runs = false;
      if (!read_row(row, has_runs)) return false;
      const std::size_t step = has_runs ? 1 : 4, component = has_runs ? width : 1;
      for (std::size_t x = 0; x < width; ++x, out += 3) {
        const int exponent = row[step * x + 3 * component];
        // Ward adds 0.5 to each component; without it 1 stays 1
        const float scale = exponent == 0 ? 0.0f : std::ldexp(1.0f, exponent - (128 + 8));
        for (std::size_t c = 0; c < 3; ++c) out[c] = static_cast<float>(row[step * x + c * component]) * scale;
      }
    }
    return true;
  }

 private:
  std::string read_line() {
    constexpr std::size_t kMaxLine = std::size_t{1} << 16;
    std::string line;
    for (int c = stream_.get(); c >= 0 && c != '\n' && line.size() < kMaxLine; c = stream_.get())
      line += static_cast<char>(c);
    return line;
  }

  /// Reads a row, run-length encoded if it begins with 2, 2 and the width.
  bool read_row(std::vector<unsigned char>& row, bool& has_runs) {
    constexpr std::size_t kMinWidth = 8, kMaxWidth = 0x7fff;
    const std::size_t width = row.size() / 4;
    const std::span<unsigned char> first(row.data(), std::min<std::size_t>(row.size(), 4));
    if (!stream_.read(first)) return false;
    has_runs = width >= kMinWidth && width <= kMaxWidth && row[0] == 2 && row[1] == 2 && row[2] < 128;
    if (!has_runs) return stream_.read(std::span(row).subspan(4));
    if ((static_cast<std::size_t>(row[2]) << 8 | row[3]) != width) return false;
    for (std::size_t c = 0; c < 4; ++c)
      if (!read_runs({row.data() + c * width, width})) return false;
    return true;
  }

  /// Reads one component of a row: a count above 128 and the value to repeat, or a count and as many values.
  bool read_runs(std::span<unsigned char> out) {
    constexpr std::size_t kRun = 128;
    while (!out.empty()) {
      const int code = stream_.get();
      if (code <= 0) return false;
      const bool repeats = static_cast<std::size_t>(code) > kRun;
      const std::size_t count = static_cast<std::size_t>(code) - (repeats ? kRun : 0);
      if (count > out.size()) return false;
      if (repeats) {
        const int value = stream_.get();
        if (value < 0) return false;
        std::fill_n(out.begin(), count, static_cast<unsigned char>(value));
      } else if (!stream_.read(out.first(count))) {
        return false;
      }
      out = out.subspan(count);
    }
    return true;
  }

  ImageStream stream_;
};

}  // namespace

std::unique_ptr<ImageReader> open_radiance(ImageSource source, std::string& problem) {
  auto reader = std::make_unique<RadianceReader>(std::move(source));
  if (!reader->open(problem)) return nullptr;
  return reader;
}

}  // namespace sheaf
