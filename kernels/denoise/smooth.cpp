#include "kernels/denoise/smooth.h"

#include "core/color/color.h"

#include <tbb/parallel_for.h>

#include <algorithm>

namespace sheaf {

Plane box_mean(const Plane& plane, int radius) {
  const int width = plane.width(), height = plane.height();
  Plane across(width, height), mean(width, height);
  // Average along rows
  tbb::parallel_for(0, height, [&](int y) {
    const float* const in = plane.row(y);
    float* const out = across.row(y);
    for (int x = 0; x < width; ++x) {
      const int first = std::max(x - radius, 0), last = std::min(x + radius, width - 1);
      float sum = 0;
      for (int i = first; i <= last; ++i) sum += in[i];
      out[x] = sum / static_cast<float>(last - first + 1);
    }
  });
  // Average along columns
  tbb::parallel_for(0, height, [&](int y) {
    const int first = std::max(y - radius, 0), last = std::min(y + radius, height - 1);
    float* const out = mean.row(y);
    for (int i = first; i <= last; ++i) {
      const float* const in = across.row(i);
      for (int x = 0; x < width; ++x) out[x] += in[x];
    }
    for (int x = 0; x < width; ++x) out[x] /= static_cast<float>(last - first + 1);
  });
  mean.extend();
  return mean;
}

Plane luminance_of(const Planes3& color) {
  Plane plane(color[0].width(), color[0].height());
  tbb::parallel_for(0, plane.height(), [&](int y) {
    for (int x = 0; x < plane.width(); ++x)
      plane.at(x, y) = luminance({color[0].at(x, y), color[1].at(x, y), color[2].at(x, y)});
  });
  return plane;
}

}  // namespace sheaf
