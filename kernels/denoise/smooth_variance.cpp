#include "kernels/denoise/smooth_variance.h"

#include "kernels/denoise/smooth.h"

#include <tbb/parallel_for.h>

#include <algorithm>

namespace sheaf {

namespace {

/// Radius of the squares.
constexpr int kRadius = 1;
/// Minimum ratio of the result to a pixel's own variance.
constexpr float kMinVarianceRatio = 0.3f;
/// Minimum brightness ratio of a pixel that shows another object.
constexpr float kBrighter = 2.0f;

/// Minimum and maximum luminance of both halves, per pixel.
struct LuminanceRange {
  Plane smallest, largest;

  explicit LuminanceRange(const Planes3* halves) : smallest(luminance_of(halves[0])), largest(luminance_of(halves[1])) {
    tbb::parallel_for(0, smallest.height(), [&](int y) {
      for (int x = 0; x < smallest.width(); ++x) {
        const auto [low, high] = std::minmax({smallest.at(x, y), largest.at(x, y)});
        smallest.at(x, y) = low;
        largest.at(x, y) = high;
      }
    });
  }

  bool is_brighter(int x, int y, int than_x, int than_y) const {
    return smallest.at(x, y) > kBrighter * largest.at(than_x, than_y);
  }
};

void smooth_pixel(const Planes3& variance, const LuminanceRange& range, int x, int y, Planes3& out) {
  float sums[3] = {}, count = 0;
  for (int j = std::max(y - kRadius, 0); j <= std::min(y + kRadius, range.smallest.height() - 1); ++j)
    for (int i = std::max(x - kRadius, 0); i <= std::min(x + kRadius, range.smallest.width() - 1); ++i) {
      if (range.is_brighter(i, j, x, y)) continue;
      for (std::size_t c = 0; c < 3; ++c) sums[c] += variance[c].at(i, j);
      ++count;
    }
  for (std::size_t c = 0; c < 3; ++c) out[c].at(x, y) = sums[c] / std::max(count, 1.0f);
}

}  // namespace

Planes3 smooth_variance(const Planes3& variance, const Planes3* halves) {
  const int width = variance[0].width(), height = variance[0].height();
  Planes3 out;
  if (halves == nullptr) {
    for (std::size_t c = 0; c < 3; ++c) out[c] = box_mean(variance[c], kRadius);
  } else {
    const LuminanceRange range(halves);
    for (Plane& plane : out) plane = Plane(width, height);
    tbb::parallel_for(0, height, [&](int y) {
      for (int x = 0; x < width; ++x) smooth_pixel(variance, range, x, y, out);
    });
  }
  for (std::size_t c = 0; c < 3; ++c) {
    tbb::parallel_for(0, height, [&](int y) {
      for (int x = 0; x < width; ++x)
        out[c].at(x, y) = std::max(out[c].at(x, y), kMinVarianceRatio * variance[c].at(x, y));
    });
    out[c].extend();
  }
  return out;
}

}  // namespace sheaf
