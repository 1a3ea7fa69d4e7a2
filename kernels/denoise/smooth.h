// Means over squares of pixels, and of colours.
#pragma once

#include "kernels/denoise/plane.h"

namespace sheaf {

/// The mean over the square of 2 * radius + 1 pixels around each pixel, of those that are in the picture. The result is
/// extended.
Plane box_mean(const Plane& plane, int radius);

/// The luminance of linear sRGB colours.
Plane luminance_of(const Planes3& color);

}  // namespace sheaf
