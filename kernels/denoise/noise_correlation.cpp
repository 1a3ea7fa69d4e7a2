#include "kernels/denoise/noise_correlation.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace sheaf {

namespace {

/// Clamp of the noise, in standard deviations, so that rare bright samples do not dominate.
constexpr float kMaxDeviations = 3.0f;
/// Correlations that differ from 0 by fewer standard deviations are set to 0.
constexpr double kSignificanceThreshold = 3.0;

/// Difference of the halves in units of its standard deviation.
Plane normalized_noise(const Plane& half, const Plane& other, const Plane& variance) {
  Plane noise(half.width(), half.height());
  tbb::parallel_for(0, half.height(), [&](int y) {
    for (int x = 0; x < half.width(); ++x) {
      const float deviation = std::sqrt(2 * variance.at(x, y));
      const float value = deviation > 0 ? (half.at(x, y) - other.at(x, y)) / deviation : 0.0f;
      noise.at(x, y) = std::clamp(value, -kMaxDeviations, kMaxDeviations);
    }
  });
  return noise;
}

/// Sum of the products of all pixels with those at the offset (dx, dy), dy >= 0. Sums are formed by rows, so the bits
/// do not depend on the number of threads.
double sum_of_products(const Plane& noise, int dx, int dy) {
  const int width = noise.width(), height = noise.height();
  std::vector<double> rows(static_cast<std::size_t>(std::max(height - dy, 0)));
  tbb::parallel_for(0, height - dy, [&](int y) {
    const float *const here = noise.row(y), *const there = noise.row(y + dy) + dx;
    double sum = 0;
    for (int x = std::max(0, -dx); x < std::min(width, width - dx); ++x)
      sum += static_cast<double>(here[x]) * static_cast<double>(there[x]);
    rows[static_cast<std::size_t>(y)] = sum;
  });
  double sum = 0;
  for (const double row : rows) sum += row;
  return sum;
}

}  // namespace

NoiseCorrelation::NoiseCorrelation(const Planes3& half, const Planes3& other, const Planes3& variance)
    : NoiseCorrelation() {
  Plane noise[3];
  double whole = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    noise[c] = normalized_noise(half[c], other[c], variance[c]);
    whole += sum_of_products(noise[c], 0, 0);
  }
  if (!(whole > 0)) return;
  // The correlation of two sets of n independent numbers has the standard deviation 1 / sqrt(n). The color channels are
  // assumed to be fully correlated, so n is the number of pixels.
  const double pixels = static_cast<double>(noise[0].width()) * noise[0].height();
  const double threshold = kSignificanceThreshold / std::sqrt(pixels);
  for (int dy = 0; dy <= kReach; ++dy)
    for (int dx = dy == 0 ? 1 : -kReach; dx <= kReach; ++dx) {
      double sum = 0;
      for (const Plane& plane : noise) sum += sum_of_products(plane, dx, dy);
      const double value = sum / whole;
      if (std::abs(value) <= threshold) continue;
      values_[index(dx, dy)] = values_[index(-dx, -dy)] = static_cast<float>(std::clamp(value, -1.0, 1.0));
    }
}

}  // namespace sheaf
