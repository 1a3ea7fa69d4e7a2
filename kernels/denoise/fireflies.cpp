#include "kernels/denoise/fireflies.h"

#include "kernels/denoise/smooth.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace sheaf {

namespace {

/// Minimum ratio of a firefly's luminance to that of its second brightest neighbor.
constexpr float kExcess = 4.0f;
/// Two halves of the samples: minimum ratio of the other half's excess to that of this half for a pixel that is kept.
constexpr float kMinSupport = 0.4f;
/// One half: minimum ratio of the squared excess to the variance for a pixel that is kept; three standard deviations.
constexpr float kMinDeviationSquared = 9.0f;

/// Two halves: radius of the splat that a sample leaves under the pixel filter. Splats are compared with the square of
/// this radius around their brightest pixel in both halves, of which they cover less than half.
constexpr int kSplatRadius = 2;
/// Two halves: minimum distance of a splat from the median of the square, in standard deviations.
constexpr float kMinDistance = 8.0f;
/// Two halves: radius of the neighborhood over which the denoiser would spread a splat.
constexpr int kSpreadRadius = 10;
/// Two halves: splats are kept if those in the neighborhood that are no brighter add up to this multiple of their
/// excess. Several splats in a neighborhood are an estimate of light that few paths find; fewer become visible discs.
constexpr float kMinCompany = 3.0f;

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

/// Calls f(x, y) for the pixels of a plane within a radius of a pixel.
template <class F> void for_square(const Plane& plane, int x, int y, int radius, F f) {
  for (int j = std::max(y - radius, 0); j <= std::min(y + radius, plane.height() - 1); ++j)
    for (int i = std::max(x - radius, 0); i <= std::min(x + radius, plane.width() - 1); ++i) f(i, j);
}

/// Pixels of one half that bright samples made brighter than those around, and which the other half does not confirm.
class Splats {
 public:
  Splats(const Plane& light, const Plane& other)
      : light_(light), other_(other), excess_(light.width(), light.height()) {
    tbb::parallel_for(0, light.height(), [&](int y) {
      for (int x = 0; x < light.width(); ++x) excess_.at(x, y) = excess(x, y);
    });
  }

  /// Calls f(pixel to replace, pixel that replaces it) for the pixels of splats without company.
  template <class F> void for_isolated(F f) const {
    for (int y = 0; y < light_.height(); ++y)
      for (int x = 0; x < light_.width(); ++x) {
        if (excess_.at(x, y) == 0 || has_company(x, y)) continue;
        const Surroundings around(*this, x, y);
        for_square(light_, x, y, kSplatRadius, [&](int i, int j) {
          if (around.differs(i, j)) f(i, j, around.median_x, around.median_y);
        });
      }
  }

 private:
  /// The square around a pixel in both halves.
  struct Surroundings {
    const Splats& splats;
    float median, deviation;
    int median_x = 0, median_y = 0;  ///< the pixel of this half that is nearest to the median

    Surroundings(const Splats& all, int x, int y) : splats(all) {
      std::array<float, 2 * (2 * kSplatRadius + 1) * (2 * kSplatRadius + 1)> values;
      std::size_t count = 0;
      for_square(all.light_, x, y, kSplatRadius, [&](int i, int j) {
        values[count++] = all.light_.at(i, j);
        values[count++] = all.other_.at(i, j);
      });
      const auto find_median = [&]() {
        std::nth_element(&values[0], &values[count / 2], &values[0] + count);
        return values[count / 2];
      };
      median = find_median();
      for (std::size_t i = 0; i < count; ++i) values[i] = std::abs(values[i] - median);
      constexpr float kDeviations = 1.4826f;  // of a normal distribution, per median distance from the median
      deviation = kDeviations * find_median();
      float nearest = std::numeric_limits<float>::infinity();
      for_square(all.light_, x, y, kSplatRadius, [&](int i, int j) {
        const float distance = std::abs(all.light_.at(i, j) - median);
        if (distance >= nearest) return;
        nearest = distance;
        median_x = i;
        median_y = j;
      });
    }

    bool differs(int x, int y) const {
      const float distance = splats.light_.at(x, y) - median;
      return distance > kMinDistance * deviation && splats.other_.at(x, y) - median < kMinSupport * distance;
    }
  };

  /// The summed excess of a splat if the pixel is its brightest, else 0.
  float excess(int x, int y) const {
    if (!(light_.at(x, y) > other_.at(x, y))) return 0;
    float largest = 0, sum = 0;
    for_square(light_, x, y, kSplatRadius, [&](int i, int j) { largest = std::max(largest, light_.at(i, j)); });
    if (light_.at(x, y) < largest) return 0;
    const Surroundings around(*this, x, y);
    if (!around.differs(x, y)) return 0;
    for_square(light_, x, y, kSplatRadius, [&](int i, int j) {
      if (around.differs(i, j)) sum += light_.at(i, j) - around.median;
    });
    return sum;
  }

  bool has_company(int x, int y) const {
    const float own = excess_.at(x, y);
    float sum = 0;
    for_square(light_, x, y, kSpreadRadius, [&](int i, int j) { sum += std::min(excess_.at(i, j), own); });
    return sum >= kMinCompany * own;
  }

  const Plane& light_;
  const Plane& other_;
  Plane excess_;
};

}  // namespace

void remove_fireflies(Planes3& color, Planes3& variance, const Planes3* other) {
  const Planes3 color_before = color, variance_before = variance;
  const Plane light = luminance_of(color), other_light = other != nullptr ? luminance_of(*other) : Plane();
  const Plane& spread = variance_before[1];
  const auto replace = [&](int x, int y, int from_x, int from_y) {
    for (std::size_t c = 0; c < 3; ++c) {
      color[c].at(x, y) = color_before[c].at(from_x, from_y);
      variance[c].at(x, y) = variance_before[c].at(from_x, from_y);
    }
  };
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
      if (!is_significant) replace(x, y, median.x, median.y);
    }
  });
  if (other != nullptr) Splats(light, other_light).for_isolated(replace);
}

}  // namespace sheaf
