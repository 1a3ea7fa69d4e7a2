// Per-pixel selection among the results of several filters.
#pragma once

#include "kernels/denoise/nl_means.h"

namespace sheaf {

/// Blends the filters' results, mostly taking the one with the smallest estimated error at each pixel. The estimate is
/// Stein's unbiased risk estimate (SURE; Li, Wu and Chuang, "SURE-based Optimization for Adaptive Sampling and
/// Reconstruction", 2012, equation 5): (F - c)^2 - V + 2 V dF/dc with the filter's result F, the noisy value c and its
/// variance V. The weights come from other samples, so dF/dc is the weight of the pixel's own noise in the result,
/// including noise that it shares with nearby pixels.
///
/// The estimate is noisy. It is smoothed before the best filter is selected, and the selection is smoothed afterwards
/// to hide seams between filters (Rousselle et al. 2013, section 4). `variance`: each pixel's own variance, not
/// smoothed. Otherwise dark pixels near a bright one would receive its variance and select the strongest filter.
Planes3 select_filters(std::vector<FilteredPlanes> filters, const Planes3& color, const Planes3& variance);

}  // namespace sheaf
