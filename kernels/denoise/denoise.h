// Denoising of finished pictures.
#pragma once

#include "core/exr.h"

#include <string>

namespace sheaf {

/// The methods.
enum class Denoiser {
  kNlMeans,  ///< non-local means, guided by features and variances; see nl_means.h
  kOidn,     ///< Open Image Denoise, if it is installed; see oidn.h
};

/// A denoised picture, and how it came about.
struct DenoiseResult {
  /// The picture, all of its channels as they were, and denoised.R/G/B besides (in place of what was so called).
  Image image;
  std::string description;  ///< one line, e.g. "nlm: two halves, features albedo N Z"
};

/// Denoises R, G and B. What other channels there are makes it better: half.R/G/B, the mean of one half of the samples;
/// albedo.R/G/B, N.X/Y/Z and Z, features of the surfaces seen; and the variances of features. Non-local means need
/// variance.R/G/B. Throws Error (exit code 2) if a channel is missing that is needed, (exit code 1) if the method is
/// not there. `threads`: 0 for one on each logical core; with kNlMeans the same bits for any number of them.
DenoiseResult denoise(const Image& image, Denoiser denoiser, int threads = 0);

/// The method called "nlm" or "oidn".
Denoiser denoiser_from_name(const std::string& name);

/// Throws Error (exit code 1) if the method cannot be used on this machine.
void check_denoiser(Denoiser denoiser);

/// Notes in a file's metadata how it was denoised, in "sheaf/denoiser".
void add_denoise_attribute(ExrMetadata& metadata, const DenoiseResult& result);

/// R, G and B are denoised.R/G/B, A is as it was, other channels are left out: for formats that know one picture alone.
Image denoised_only(const Image& image);

}  // namespace sheaf
