// Denoising of finished images: non-local means, or Open Image Denoise.
#pragma once

#include "core/image/exr.h"
#include "core/io/name_table.h"

#include <string>

namespace sheaf {

/// Denoising methods.
enum class Denoiser {
  kNlMeans,  ///< non-local means, guided by features and variances; see nl_means.h
  kOidn,     ///< Open Image Denoise, if installed; see oidn.h
};

/// A denoised image, and a description of the method.
struct DenoiseResult {
  /// The image with all of its channels unchanged, plus denoised.R/G/B (existing ones are replaced).
  Image image;
  std::string description;  ///< one line, e.g. "nlm: two halves, features albedo N Z"
};

/// Denoises R, G and B. Optional channels improve the result: half.R/G/B, the mean of one half of the samples;
/// albedo.R/G/B, N.X/Y/Z and Z, features of the visible surfaces; and the variances of features. Non-local means
/// require variance.R/G/B. Throws Error (exit code 2) if a required channel is missing, and Error (exit code 1) if the
/// method is not available. `threads`: 0 for one per logical core. The bits of kNlMeans do not depend on the number of
/// threads.
DenoiseResult denoise(const Image& image, Denoiser denoiser, int threads = 0);

/// Names of the methods on the command line.
inline constexpr NameTable<Denoiser> kDenoisers{{{"nlm", Denoiser::kNlMeans}, {"oidn", Denoiser::kOidn}}};

/// Throws Error (exit code 1) if the method cannot be used on this machine.
void check_denoiser(Denoiser denoiser);

/// kOidn if its library is installed, otherwise kNlMeans.
Denoiser best_denoiser();

/// Records the denoiser in the file's metadata as "sheaf/denoiser".
void add_denoise_attribute(ExrMetadata& metadata, const DenoiseResult& result);

/// Image with R, G and B from denoised.R/G/B, and A unchanged. Omits other channels, for formats without layers.
Image denoised_only(const Image& image);

}  // namespace sheaf
