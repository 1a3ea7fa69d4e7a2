// Of several filters' results, the best at each pixel.
#pragma once

#include "kernels/denoise/nl_means.h"

namespace sheaf {

/// Mixes the filters' results, at each pixel mostly the one of least estimated error. The estimate is Stein's (SURE;
/// Li, Wu and Chuang, "SURE-based Optimization for Adaptive Sampling and Reconstruction", 2012, equation 5), (F - c)^2
/// - V + 2 V dF/dc with the filter's result F, the noisy value c and its variance V, where dF/dc is the share of itself
/// that a pixel's result holds, and of the noise that it shares with near pixels: the weights come from other samples.
/// It is noisy, and so is smoothed over the picture before the best filter is taken and once more after, which keeps
/// seams between filters from being seen (Rousselle et al. 2013, section 4). `variance` is each pixel's own, not
/// smoothed: what is spread to dark pixels around a bright one would make them choose whatever smooths most.
Planes3 select_filters(std::vector<FilteredPlanes> filters, const Planes3& color, const Planes3& variance);

}  // namespace sheaf
