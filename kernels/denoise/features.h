// Feature buffers (albedo, normal, depth) that guide the denoiser.
#pragma once

#include "core/image/image.h"
#include "kernels/denoise/nl_means.h"

namespace sheaf {

/// Features of an image: albedo.R/G/B, N.X/Y/Z and Z, any of which may be missing. Features with a variance
/// (variance.albedo.R and so on) are first denoised by separate non-local means (Rousselle et al. 2013, section 5.1).
/// `correlation`: correlation of the noise.
std::vector<Feature> find_features(const Image& image, const NoiseCorrelation& correlation);

/// The named channels of an image as planes, with extended borders. Non-finite and huge values become 0. Returns an
/// empty list if a channel is missing.
std::vector<Plane> find_planes(const Image& image, const std::vector<std::string>& names);

}  // namespace sheaf
