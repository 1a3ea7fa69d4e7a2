// Noise estimates: the variance of pixel means, absolute and relative to the pixel value.
#pragma once

#include "core/image/image.h"

#include <cmath>
#include <limits>
#include <optional>
#include <vector>

namespace sheaf {

/// Variance of the mean m = sum of S_u / sum of W_u over units, see Film. `weight`, `weight_squared`, `square` and
/// `cross` are the sums of W_u, W_u^2, S_u^2 and S_u W_u. Returns 0 for a single unit.
inline double variance_of_mean(double mean, double weight, double weight_squared, double square, double cross) {
  const double total = weight * weight, rest = 1.0 - weight_squared / total;
  // For a single unit only rounding errors remain.
  if (!(rest > 1e-9)) return 0.0;
  const double scatter = square - 2.0 * mean * cross + mean * mean * weight_squared;
  return (scatter > 0.0 ? scatter : 0.0) / (total * rest);
}

/// Whether a pixel has only one unit, so that its variance is unknown.
inline bool is_single_unit(double weight, double weight_squared) {
  return weight > 0.0 && !(1.0 - weight_squared / (weight * weight) > 1e-9);
}

/// Whether so many pixels lack a variance that the image's noise is unknown: more than 0.1%.
inline bool is_noise_unknown(std::size_t unknown, std::size_t pixels) { return unknown > pixels / 1000; }

/// Upper bound that keeps the variances of very bright pixels finite in single precision.
inline constexpr double kLargestVariance = std::numeric_limits<float>::max();

inline constexpr double kLuminance[3] = {0.2126, 0.7152, 0.0722};  ///< of linear Rec.709

/// Luminance of linear Rec.709.
inline double luminance_of(const double* rgb) {
  return kLuminance[0] * rgb[0] + kLuminance[1] * rgb[1] + kLuminance[2] * rgb[2];
}

/// Relative variance of a pixel. Dark pixels count as if they had a tenth of the image's `mean`.
inline double relative_square(double value, double variance, double mean) {
  constexpr double kDark = 0.1;
  return variance / (value * value + kDark * mean * (kDark * mean) + 1e-30);
}

/// Noise of an image, computed from its layers as by Film::noise(). Returns nothing if R, G and B have no variances, or
/// if more than 0.1% of the pixels have fewer than two samples.
std::optional<double> image_noise(const Image& image);

/// Mean without the largest 0.1% of the values; 0 for an empty list. Reorders `values`.
double mean_but_worst(std::vector<double>& values);

/// Computes Film::noise() pixel by pixel.
class ImageNoise {
 public:
  /// `value` and `variance`: R, G and B of one pixel.
  void add(const float* value, const float* variance);
  double noise();

 private:
  std::vector<double> values_, relative_;
  double sum_ = 0;
};

}  // namespace sheaf
