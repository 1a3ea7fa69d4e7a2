// Open Image Denoise, Intel's library of neural filters, if this machine has it: it is looked for when it is asked for.
#pragma once

#include "core/image.h"
#include "kernels/denoise/plane.h"

#include <string>

namespace sheaf {

/// Throws Error (exit code 1) if the library cannot be loaded.
void check_oidn();

/// R, G and B denoised, with albedo.R/G/B and N.X/Y/Z where the picture has them; says in `description` with what.
/// Throws Error (exit code 1).
Planes3 denoise_oidn(const Image& image, std::string& description);

}  // namespace sheaf
