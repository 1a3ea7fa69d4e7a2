// How noisy pixels are: the variance of their means, and that over their values.
#pragma once

#include "core/image.h"

#include <cmath>
#include <limits>
#include <optional>
#include <vector>

namespace sheaf {

/// The variance of the mean m = sum of S_u / sum of W_u of units, as Film says: `weight`, `weight_squared`, `square`
/// and `cross` are the sums of W_u, W_u^2, S_u^2 and S_u W_u. 0 for a single unit.
inline double variance_of_mean(double mean, double weight, double weight_squared, double square, double cross) {
  const double total = weight * weight, rest = 1.0 - weight_squared / total;
  // A single unit leaves nothing but rounding.
  if (!(rest > 1e-9)) return 0.0;
  const double scatter = square - 2.0 * mean * cross + mean * mean * weight_squared;
  return (scatter > 0.0 ? scatter : 0.0) / (total * rest);
}

/// Whether there is but one unit, whose spread tells nothing.
inline bool is_single_unit(double weight, double weight_squared) {
  return weight > 0.0 && !(1.0 - weight_squared / (weight * weight) > 1e-9);
}

/// Whether so many of a picture's pixels are without a variance that its noise is unknown.
inline bool is_noise_unknown(std::size_t unknown, std::size_t pixels) { return unknown > pixels / 1000; }

/// Variances of very bright pixels stay finite in single precision.
inline constexpr double kLargestVariance = std::numeric_limits<float>::max();

inline constexpr double kLuminance[3] = {0.2126, 0.7152, 0.0722};  ///< of linear Rec.709

/// Of R, G and B.
inline double luminance_of(const double* rgb) {
  return kLuminance[0] * rgb[0] + kLuminance[1] * rgb[1] + kLuminance[2] * rgb[2];
}

/// The variance of a pixel's value over its square. Dark pixels count as if they had a tenth of the picture's `mean`.
inline double relative_square(double value, double variance, double mean) {
  constexpr double kDark = 0.1;
  return variance / (value * value + kDark * mean * (kDark * mean) + 1e-30);
}

/// How noisy a picture is, from its layers, as Film::noise() says; nothing where R, G and B have no variances, or where
/// more than a thousandth of the pixels have fewer than two samples.
std::optional<double> picture_noise(const Image& image);

/// The mean without the largest thousandth; 0 of nothing. Reorders `values`.
double mean_but_worst(std::vector<double>& values);

/// Adds up Film::noise(), pixel by pixel.
class PictureNoise {
 public:
  /// Both of R, G and B.
  void add(const float* value, const float* variance);
  double noise();

 private:
  std::vector<double> values_, relative_;
  double sum_ = 0;
};

}  // namespace sheaf
