#include "kernels/denoise/select_filters.h"

#include "kernels/denoise/smooth.h"

#include <tbb/parallel_for.h>

#include <algorithm>

namespace sheaf {

namespace {

/// Radii of the squares over which errors and then the selection are smoothed.
constexpr int kErrorRadius = 2, kChoiceRadius = 4;

/// SURE per pixel, relative to the pixel's brightness so that bright pixels do not dominate their neighborhood.
Plane estimate_error(const FilteredPlanes& filter, const Planes3& color, const Planes3& variance) {
  Plane error(color[0].width(), color[0].height());
  tbb::parallel_for(0, error.height(), [&](int y) {
    for (int x = 0; x < error.width(); ++x) {
      float sum = 0, square = 1e-20f;
      for (std::size_t c = 0; c < 3; ++c) {
        const float f = filter.color[c].at(x, y), v = variance[c].at(x, y);
        sum += sqr(f - color[c].at(x, y)) - v + 2 * v * filter.self_weight.at(x, y);
        square += sqr(color[c].at(x, y)) + v;
      }
      error.at(x, y) = sum / square;
    }
  });
  return box_mean(box_mean(error, kErrorRadius), kErrorRadius);
}

}  // namespace

Planes3 select_filters(std::vector<FilteredPlanes> filters, const Planes3& color, const Planes3& variance) {
  const int width = color[0].width(), height = color[0].height();
  std::vector<Plane> errors, weights;
  for (const FilteredPlanes& filter : filters) {
    errors.push_back(estimate_error(filter, color, variance));
    weights.emplace_back(width, height);
  }
  for (int y = 0; y < height; ++y)
    // Select the filter with the smallest error.
    for (int x = 0; x < width; ++x) {
      std::size_t best = 0;
      for (std::size_t i = 1; i < filters.size(); ++i)
        if (errors[i].at(x, y) < errors[best].at(x, y)) best = i;
      weights[best].at(x, y) = 1;
    }
  // Smooth the selection and blend the results with it.
  for (Plane& weight : weights) weight = box_mean(weight, kChoiceRadius);
  Planes3 out;
  for (std::size_t c = 0; c < 3; ++c) {
    out[c] = Plane(width, height);
    tbb::parallel_for(0, height, [&](int y) {
      for (std::size_t i = 0; i < filters.size(); ++i)
        for (int x = 0; x < width; ++x) out[c].at(x, y) += weights[i].at(x, y) * filters[i].color[c].at(x, y);
    });
  }
  return out;
}

}  // namespace sheaf
