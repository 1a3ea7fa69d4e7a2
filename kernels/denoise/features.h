// Features: what surfaces look like without light, made ready to be compared.
#pragma once

#include "core/image.h"
#include "kernels/denoise/nl_means.h"

namespace sheaf {

/// The features that a picture has: albedo.R/G/B, N.X/Y/Z and Z, of which any may be missing. Those with a variance
/// (variance.albedo.R and so on) are denoised first, each by non-local means of its own (Rousselle et al. 2013,
/// section 5.1). `correlation` is that of the noise.
std::vector<Feature> find_features(const Image& image, const NoiseCorrelation& correlation);

/// The channels of a picture of these names as planes, extended; values that are not finite are 0. Empty if one is
/// missing.
std::vector<Plane> find_planes(const Image& image, const std::vector<std::string>& names);

}  // namespace sheaf
