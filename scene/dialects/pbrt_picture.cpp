// The pbrt dialect: what must be known of pictures before they are used.
#include "core/color.h"
#include "scene/dialects/pbrt.h"

#include <cmath>

namespace sheaf::pbrt {

Image read_linear_picture(const std::filesystem::path& file, bool raw, const SourceLocation& where) {
  try {
    const Picture picture = read_picture(file);
    Image out(picture.width, picture.height, {"R", "G", "B"});
    const bool decode = !raw && (picture.integers || !picture.bytes.empty());
    const std::size_t stride = picture.channels.size();
    const bool coloured = stride >= 3;
    for (std::size_t pixel = 0; pixel < out.pixel_count(); ++pixel)
      for (std::size_t c = 0; c < 3; ++c) {
        std::size_t from = coloured ? c : 0;
        for (std::size_t k = 0; coloured && k < stride; ++k)
          if (picture.channels[k] == out.channels[c]) from = k;
        const std::size_t at = pixel * stride + from;
        const float value = picture.bytes.empty() ? picture.floats[at] : static_cast<float>(picture.bytes[at]) / 255;
        if (!std::isfinite(value)) throw SceneError({file.string(), 0}, "a pixel is not a finite number");
        out.data[3 * pixel + c] = decode ? srgb_to_linear(value) : value;
      }
    return out;
  } catch (const SceneError& error) { throw SceneError(where, error.what()); }
}

double mean_luminance(const Image& picture, double (*weight)(const double* about, double x, double y),
                      const double* about) {
  double sum = 0;
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) {
      const Vec3f rgb{picture.at(x, y, 0), picture.at(x, y, 1), picture.at(x, y, 2)};
      sum += double{luminance(rgb)} * weight(about, (x + 0.5) / picture.width, (y + 0.5) / picture.height);
    }
  return sum / static_cast<double>(picture.pixel_count());
}

double mean_luminance(const Image& picture) {
  return mean_luminance(
      picture, [](const double*, double, double) { return 1.0; }, nullptr);
}

}  // namespace sheaf::pbrt
