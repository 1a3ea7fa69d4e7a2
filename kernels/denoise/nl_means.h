// Non-local means: every pixel becomes a mean of pixels near it whose surroundings look like its own.
//
// Rousselle, Knaus and Zwicker, "Adaptive Rendering with Non-Local Means Filtering" (2012): the squared difference of
// two pixels is freed from what noise alone adds to it and measured in units of that noise (equation 3), averaged over
// patches, and turned into a weight. With two halves of the samples each half is weighed by the other, so that its
// noise does not choose what it is averaged with. Rousselle, Manzi and Zwicker, "Robust Denoising using Feature and
// Color Information" (2013): weights are at most what features (albedo, normal, depth) allow, and several filters run
// side by side, of which the best is chosen at each pixel by its estimated error; see select_filters.h. Some fit a
// plane to the weighted pixels, whose value at the pixel replaces the mean, so that slopes aren't levelled (Moon, Carr
// and Yoon, "Adaptive Rendering Based on Weighted Local Regression", 2014, with the place in the picture as the only
// feature).
#pragma once

#include "core/pixel_rect.h"
#include "kernels/denoise/noise_correlation.h"
#include "kernels/denoise/plane.h"

#include <vector>

namespace sheaf {

/// What surfaces look like without light: up to three channels that are compared as one.
struct Feature {
  std::vector<Plane> channels;  ///< extended
  /// Per pixel: one over the squared difference that makes a weight of exp(-1). See make_feature().
  Plane scale;
  /// How much the first channel changes from a pixel to the next one, to the right and down, where that change is to be
  /// no difference; extended. Empty: every change is one.
  Plane slope_x, slope_y;
};

/// What is filtered, and by what its pixels are compared.
struct NlMeansInput {
  int width = 0, height = 0;
  int halves = 1;                 ///< 2: `half` holds means of two sets of samples that are independent of each other
  Planes3 half[2];                ///< extended; the second is empty if there is but one
  Planes3 variance;               ///< extended; of the mean of one half, smooth enough to divide by
  NoiseCorrelation correlation;   ///< how alike the noise of near pixels is
  std::vector<Feature> features;  ///< none, or all that there are
  float epsilon = 1e-10f;         ///< squared difference that never matters
};

/// The filters that run side by side.
enum NlMeansFilter : int {
  kSmallPatch,  ///< by patches of 3 x 3 pixels, and features; fits planes
  kLargePatch,  ///< by patches of 7 x 7 pixels, and features; fits planes
  kColorOnly,   ///< by patches of 7 x 7 pixels alone: what is seen in mirrors and glass; only where there are features
  /// By features, and by patches of 7 x 7 pixels far less strictly, so that no lamp is smeared; only where there are
  /// features.
  kMostlyFeatures,
  kMaxFilters
};

/// How strongly filters smooth.
struct NlMeansSettings {
  int radius = 10;       ///< of the disc around a pixel in which it looks for others like it; at most kMaxRadius
  float color_k = 0.7f;  ///< differences in units of the noise's standard deviation that count as one
};
inline constexpr int kMaxRadius = 12;

/// What one filter makes.
struct FilteredPlanes {
  Planes3 color;      ///< the mean of both halves
  Plane self_weight;  ///< the share of a pixel's own noise in its result: by its weight, and by those of near pixels
};

/// Runs all filters that the input allows: two without features, else four. Uses threads; the same bits for any number
/// of them.
std::vector<FilteredPlanes> nl_means(const NlMeansInput& input, const NlMeansSettings& settings);

/// The pixels of a tile, in planes of the whole picture. L: Wide, or Scalar with the same bits.
template <class L>
void nl_means_tile(const NlMeansInput& input, const NlMeansSettings& settings, const PixelRect& tile,
                   std::vector<FilteredPlanes>& out);

/// What nl_means() writes to, for tiles.
std::vector<FilteredPlanes> make_filtered_planes(const NlMeansInput& input);

}  // namespace sheaf
