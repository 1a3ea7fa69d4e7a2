// The pbrt dialect: inspection and conversion of image files.
#include "core/color/srgb_bytes.h"
#include "core/image/image_channels.h"
#include "core/io/parallel_ranges.h"
#include "scene/dialects/pbrt/reader.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>

namespace sheaf::pbrt {

namespace {

/// Whether the file extension ends with `end`, ignoring case as pbrt does.
bool has_extension(const std::filesystem::path& file, std::string_view end) {
  std::string extension = file.extension().string();
  for (char& c : extension) c = static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
  return extension.ends_with(end);
}

constexpr std::size_t kPixelsPerTask = 1 << 14;

/// The colors of an image, with `map` applied to every linear value. Computes bytes by a table.
template <class Map> Image mapped_colors(const StoredImage& image, const SourceLocation& file, bool raw, Map&& map) {
  Image out(image.width, image.height, {"R", "G", "B"});
  const bool bytes = !image.bytes.empty(), decode = !raw && (image.integers || bytes);
  const std::size_t stride = image.channels.size();
  const std::vector<std::size_t> channels = find_color_channels(image.channels, file).channels;
  std::array<float, 256> table{};
  for (std::size_t i = 0; bytes && i < table.size(); ++i)
    table[i] = map(decode ? linear_of_srgb_bytes()[i] : static_cast<float>(i) / 255);
  std::atomic<bool> is_finite = true;
  parallel_ranges(
      out.pixel_count(),
      [&](std::size_t begin, std::size_t end) {
        for (std::size_t pixel = begin; pixel < end; ++pixel)
          for (std::size_t c = 0; c < 3; ++c) {
            const std::size_t at = pixel * stride + channels[std::min(c, channels.size() - 1)];
            float& to = out.data[3 * pixel + c];
            if (bytes) {
              to = table[image.bytes[at]];
            } else if (const float value = image.floats[at]; std::isfinite(value)) {
              to = map(decode ? srgb_to_linear(value) : value);
            } else {
              is_finite = false;
            }
          }
      },
      kPixelsPerTask);
  if (!is_finite) throw SceneError(file, "a pixel is not a finite number");
  return out;
}

}  // namespace

bool is_png(const std::filesystem::path& file) { return has_extension(file, "png"); }

bool may_hold_integers(const std::filesystem::path& file) {
  return !has_extension(file, "exr") && !has_extension(file, "pfm") && !has_extension(file, "hdr");
}

std::shared_ptr<const Image> base_image(const BitmapDescription& bitmap, const LayeredBase& base) {
  // A table with 1024 steps replaces the evaluation per value; it is finer than 8-bit quantization.
  constexpr int kSteps = 1024;
  std::array<float, kSteps + 2> table;
  for (int i = 0; i < kSteps + 2; ++i) table[static_cast<std::size_t>(i)] = base.albedo(static_cast<float>(i) / kSteps);
  const BitmapDescription::ColorTransform& change = bitmap.change;
  const auto to_base = [&](float value) {
    value *= change.scale;
    if (change.invert) value = 1 - value;
    value = std::clamp(value, 0.0f, 1.0f);
    if (change.exponent != 1.0f) value = std::pow(value, change.exponent);
    const float at = value * kSteps;
    const auto cell = static_cast<std::size_t>(at);
    return std::lerp(table[cell], table[cell + 1], at - static_cast<float>(cell));
  };
  if (bitmap.made) {
    auto out = std::make_shared<Image>(*bitmap.made);
    std::transform(out->data.begin(), out->data.end(), out->data.begin(), to_base);
    return out;
  }
  try {
    return std::make_shared<Image>(
        mapped_colors(read_stored_image(bitmap.file), {bitmap.file.string(), 0}, bitmap.raw, to_base));
  } catch (const SceneError&) { return nullptr; }
}

std::shared_ptr<const Image> scalar_image(const BitmapDescription& bitmap) {
  // Read the image and find its channels
  StoredImage pixels;
  try {
    pixels = read_stored_image(bitmap.file);
  } catch (const SceneError&) { return nullptr; }
  const auto channel = [&](const char* name) {
    return std::find(pixels.channels.begin(), pixels.channels.end(), name) - pixels.channels.begin();
  };
  const auto count = static_cast<std::ptrdiff_t>(pixels.channels.size());
  const std::ptrdiff_t r = channel("R"), g = channel("G"), b = channel("B"), a = channel("A");
  if (r == count || g == count || b == count) return nullptr;
  const bool decode = !bitmap.raw && (pixels.integers || !pixels.bytes.empty());
  // Access pixels as stored and as linear values
  const auto stored = [&](std::size_t pixel, std::ptrdiff_t c) {
    const std::size_t at = pixel * pixels.channels.size() + static_cast<std::size_t>(c);
    return pixels.bytes.empty() ? pixels.floats[at] : static_cast<float>(pixels.bytes[at]) / 255;
  };
  const auto linear = [&](std::size_t pixel, std::ptrdiff_t c) {
    if (!decode) return stored(pixel, c);
    if (pixels.bytes.empty()) return srgb_to_linear(stored(pixel, c));
    return linear_of_srgb_bytes()[pixels.bytes[pixel * pixels.channels.size() + static_cast<std::size_t>(c)]];
  };
  auto out = std::make_shared<Image>(pixels.width, pixels.height, std::vector<std::string>{"Y"});
  const bool has_alpha = a < count && (is_png(bitmap.file) || has_extension(bitmap.file, "exr"));
  // Use alpha unless it is 1 everywhere, otherwise the mean color
  bool uses_alpha = false;
  for (std::size_t i = 0; has_alpha && !uses_alpha && i < out->pixel_count(); ++i) uses_alpha = stored(i, a) != 1;
  for (std::size_t i = 0; i < out->pixel_count(); ++i)
    out->data[i] = uses_alpha ? linear(i, a) : (linear(i, r) + linear(i, g) + linear(i, b)) / 3;
  return out;
}

Image read_linear_image(const std::filesystem::path& file, bool raw, const SourceLocation& where) {
  try {
    return mapped_colors(read_stored_image(file), {file.string(), 0}, raw, [](float value) { return value; });
  } catch (const SceneError& error) { throw SceneError(where, error); }
}

double mean_luminance(const Image& image, double (*weight)(const double* about, double x, double y),
                      const double* about) {
  double sum = 0;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const Vec3f rgb{image.at(x, y, 0), image.at(x, y, 1), image.at(x, y, 2)};
      sum += double{luminance(rgb)} * weight(about, (x + 0.5) / image.width, (y + 0.5) / image.height);
    }
  return sum / static_cast<double>(image.pixel_count());
}

double mean_luminance(const Image& image) {
  return mean_luminance(
      image, [](const double*, double, double) { return 1.0; }, nullptr);
}

}  // namespace sheaf::pbrt
