#include "scene/film.h"

#include <algorithm>
#include <limits>

namespace sheaf {

namespace {

/// Variances of very bright pixels stay finite in single precision.
constexpr double kLargest = std::numeric_limits<float>::max();

}  // namespace

Film::Film(int frame_width, int frame_height, PixelRect crop)
    : frame_width_(frame_width),
      frame_height_(frame_height),
      crop_(crop),
      pixels_(static_cast<std::size_t>(crop.width()) * static_cast<std::size_t>(crop.height())) {}

Image Film::to_image() const {
  Image image(crop_.width(), crop_.height(), {"R", "G", "B", "A", "variance.R", "variance.G", "variance.B", "sampleCount"});
  image.x0 = crop_.x0;
  image.y0 = crop_.y0;
  image.frame_width = frame_width_;
  image.frame_height = frame_height_;
  for (std::size_t i = 0; i < pixels_.size(); ++i) {
    const Pixel& p = pixels_[i];
    if (p.count == 0) continue;
    float* out = image.data.data() + i * image.channels.size();
    const auto n = static_cast<double>(p.count);
    for (std::size_t c = 0; c < 3; ++c) {
      const double mean = p.sum[c] / n;
      out[c] = static_cast<float>(mean);
      const double variance = std::max(0.0, p.sum_of_squares[c] / n - mean * mean) / (n - 1.0);
      if (p.count > 1) out[4 + c] = static_cast<float>(std::min(variance, kLargest));
    }
    out[3] = static_cast<float>(p.alpha / n);
    out[7] = static_cast<float>(p.count);
  }
  return image;
}

}  // namespace sheaf
