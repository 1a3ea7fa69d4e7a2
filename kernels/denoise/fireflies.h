// Removal of fireflies: pixels that few samples made far brighter than their neighborhood.
#pragma once

#include "kernels/denoise/plane.h"

namespace sheaf {

/// Replaces the color and variance of fireflies by those of a typical neighbor. Otherwise the denoiser would smear them
/// into discs, because their large variance makes them similar to any pixel. There are two kinds:
/// - Single pixels with a luminance far above that of all but one of their eight neighbors.
/// - With `other`, the mean of other samples: splats, which a sample leaves in several pixels under the pixel filter,
/// far
///   above the noise of both means around. They are kept where several lie within the radius of the filters.
/// Both are kept if their excess is confirmed: `other` contains enough of it or, if it is nullptr, the pixel's variance
/// is small. Deterministic; the number of threads does not matter.
void remove_fireflies(Planes3& color, Planes3& variance, const Planes3* other);

}  // namespace sheaf
