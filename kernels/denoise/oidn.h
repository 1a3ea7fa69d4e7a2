// Denoising with Open Image Denoise, Intel's library of neural filters, which is loaded at run time on demand.
#pragma once

#include "core/image/image.h"
#include "kernels/denoise/plane.h"

#include <string>

namespace sheaf {

/// Throws Error (exit code 1) if the library cannot be loaded.
void check_oidn();

/// Denoises R, G and B, guided by albedo.R/G/B and N.X/Y/Z if the image has them. `description` receives the features
/// that were used. Throws Error (exit code 1).
Planes3 denoise_oidn(const Image& image, std::string& description);

}  // namespace sheaf
