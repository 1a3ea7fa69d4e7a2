#include "kernels/denoise/fireflies.h"

#include "kernels/denoise/smooth.h"

#include <tbb/parallel_for.h>

#include <algorithm>

namespace sheaf {

namespace {

/// Minimum ratio of a firefly's luminance to that of its second brightest neighbor.
constexpr float kExcess = 4.0f;
/// Two halves of the samples: minimum ratio of the other half's excess to that of this half for a pixel that is kept.
constexpr float kMinSupport = 0.4f;
/// One half: minimum ratio of the squared excess to the variance for a pixel that is kept; three standard deviations.
constexpr float kMinDeviationSquared = 9.0f;

/// Luminance of the second brightest neighbor; 0 if there are fewer than two.
float second_brightest(const Plane& plane, int x, int y) {
  float largest = 0, second = 0;
  for (int j = std::max(y - 1, 0); j <= std::min(y + 1, plane.height() - 1); ++j)
    for (int i = std::max(x - 1, 0); i <= std::min(x + 1, plane.width() - 1); ++i) {
      if (i == x && j == y) continue;
      second = std::max(second, std::min(plane.at(i, j), largest));
      largest = std::max(largest, plane.at(i, j));
    }
  return second;
}

/// A pixel's neighbors, sorted by luminance.
struct NeighborPixels {
  struct Pixel {
    float luminance;
    int x, y;
  };
  Pixel pixels[8];
  int count = 0;

  NeighborPixels(const Plane& plane, int x, int y) {
    for (int j = std::max(y - 1, 0); j <= std::min(y + 1, plane.height() - 1); ++j)
      for (int i = std::max(x - 1, 0); i <= std::min(x + 1, plane.width() - 1); ++i)
        if (i != x || j != y) pixels[count++] = {plane.at(i, j), i, j};
    std::stable_sort(pixels, pixels + count, [](const Pixel& a, const Pixel& b) { return a.luminance < b.luminance; });
  }
};

}  // namespace

void remove_fireflies(Planes3& color, Planes3& variance, const Planes3* other) {
  const Planes3 color_before = color, variance_before = variance;
  const Plane light = luminance_of(color), other_light = other != nullptr ? luminance_of(*other) : Plane();
  const Plane& spread = variance_before[1];
  tbb::parallel_for(0, light.height(), [&](int y) {
    for (int x = 0; x < light.width(); ++x) {
      // Find pixels that are much brighter than their second brightest neighbor
      if (!(light.at(x, y) > kExcess * second_brightest(light, x, y))) continue;
      const NeighborPixels near(light, x, y);
      if (near.count < 2) continue;
      const NeighborPixels::Pixel& median = near.pixels[near.count / 2];
      // Keep pixels whose excess is significant; replace the others by the median neighbor
      const float excess = light.at(x, y) - median.luminance;
      const bool is_significant = other != nullptr ? other_light.at(x, y) - median.luminance > kMinSupport * excess
                                                   : excess * excess > kMinDeviationSquared * spread.at(x, y);
      if (is_significant) continue;
      for (std::size_t c = 0; c < 3; ++c) {
        color[c].at(x, y) = color_before[c].at(median.x, median.y);
        variance[c].at(x, y) = variance_before[c].at(median.x, median.y);
      }
    }
  });
}

}  // namespace sheaf
