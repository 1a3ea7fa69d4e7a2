// Non-local means: each pixel becomes a weighted mean of nearby pixels whose patches are similar to its own patch.
//
// Rousselle, Knaus and Zwicker, "Adaptive Rendering with Non-Local Means Filtering" (2012): the expected contribution
// of noise is subtracted from the squared difference of two pixels, and the result is divided by the variance of the
// noise (equation 3). Averages over patches give the weights. With two halves of the samples, each half supplies the
// weights of the other, so that the noise of a half does not influence its own weights.
//
// Rousselle, Manzi and Zwicker, "Robust Denoising using Feature and Color Information" (2013): features (albedo,
// normal, depth) limit the weights. Several filters run side by side, and the one with the smallest estimated error is
// selected per pixel; see select_filters.h.
//
// Some filters fit a plane to the weighted pixels and return its value at the pixel instead of the mean. This preserves
// gradients. It follows Moon, Carr and Yoon, "Adaptive Rendering Based on Weighted Local Regression" (2014), with the
// image position as the only feature.
#pragma once

#include "core/image/pixel_rect.h"
#include "kernels/denoise/noise_correlation.h"
#include "kernels/denoise/plane.h"

#include <vector>

namespace sheaf {

/// A feature buffer: up to three channels that are compared as one vector.
struct Feature {
  std::vector<Plane> channels;  ///< with extended borders
  /// Per pixel: one over the squared difference that gives the weight exp(-1). See make_feature().
  Plane scale;
  /// Expected change of the first channel per pixel, to the right and downwards, which is subtracted from differences;
  /// with extended borders. Empty: no change is expected.
  Plane slope_x, slope_y;
};

/// Input of the filters: noisy colors, their variance and the features.
struct NlMeansInput {
  int width = 0, height = 0;
  int halves = 1;                 ///< 2: `half` holds the means of two independent sets of samples
  Planes3 half[2];                ///< with extended borders; the second is empty if `halves` is 1
  Planes3 variance;               ///< of the mean of one half, smoothed; with extended borders
  NoiseCorrelation correlation;   ///< between the noise of nearby pixels
  std::vector<Feature> features;  ///< all available features, possibly none
  float epsilon = 1e-10f;         ///< negligible squared difference
};

/// The filters that run side by side.
enum NlMeansFilter : int {
  kSmallPatch,  ///< patches of 3 x 3 pixels and features; fits planes
  kLargePatch,  ///< patches of 7 x 7 pixels and features; fits planes
  kColorOnly,   ///< patches of 7 x 7 pixels only, for objects seen in mirrors and glass; runs only with features
  /// Features, and patches of 7 x 7 pixels with a larger tolerance (kWeakColorFactor), which suffices to keep lamps
  /// sharp. Runs only with features.
  kFeatureFilter,
  kMaxFilters
};

/// Strength of the filters.
struct NlMeansSettings {
  int radius = 10;       ///< of the disc around a pixel from which the mean is taken, pixels; at most kMaxRadius
  float color_k = 0.7f;  ///< difference with distance 1, in standard deviations of the noise
};
inline constexpr int kMaxRadius = 12;

/// Result of one filter.
struct FilteredPlanes {
  Planes3 color;  ///< mean of both halves
  /// Derivative of the result by the pixel's own noise, including the noise shared with nearby pixels.
  Plane self_weight;
};

/// Runs all filters that the input supports: two without features, otherwise four. Multithreaded; the bits do not
/// depend on the number of threads.
std::vector<FilteredPlanes> nl_means(const NlMeansInput& input, const NlMeansSettings& settings);

/// Filters the pixels of one tile; planes cover the whole image. L is Wide or Scalar; both give the same bits.
template <class L>
void nl_means_tile(const NlMeansInput& input, const NlMeansSettings& settings, const PixelRect& tile,
                   std::vector<FilteredPlanes>& out);

/// Allocates the planes that nl_means_tile() writes to.
std::vector<FilteredPlanes> make_filtered_planes(const NlMeansInput& input);

}  // namespace sheaf
