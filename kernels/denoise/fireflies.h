// Removal of fireflies: single pixels that few samples made far brighter than their neighborhood.
#pragma once

#include "kernels/denoise/plane.h"

namespace sheaf {

/// Replaces the color and variance of fireflies by those of the median neighbor. Otherwise the denoiser would smear a
/// firefly into a blotch, because its large variance makes it similar to any pixel. A pixel is a firefly under two
/// conditions. Its luminance is far above that of all but one of its eight neighbors. Its excess over their median is
/// not confirmed: `other`, the mean of other samples, contains little of it; if `other` is nullptr, the pixel's
/// variance is large. Deterministic and multithreaded.
void remove_fireflies(Planes3& color, Planes3& variance, const Planes3* other);

}  // namespace sheaf
