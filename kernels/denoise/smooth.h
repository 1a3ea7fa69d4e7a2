// Box filter and luminance of planes.
#pragma once

#include "kernels/denoise/plane.h"

namespace sheaf {

/// Mean over the square of 2 * radius + 1 pixels around each pixel, clipped to the image. The result has an extended
/// border.
Plane box_mean(const Plane& plane, int radius);

/// Luminance of linear sRGB colors.
Plane luminance_of(const Planes3& color);

}  // namespace sheaf
