// Variances that can be divided by.
#pragma once

#include "kernels/denoise/plane.h"

namespace sheaf {

/// Variances of few sets of samples are as noisy as the picture itself: the mean over 3 x 3 pixels, but at least a
/// share of a pixel's own. Pixels that both halves show twice as bright as either shows this one are left out, as what
/// is seen there is another thing, say a lamp, and its noise no measure of this one's. `halves`: means of two sets of
/// samples, or nullptr for none. The result is extended. Deterministic; uses threads.
Planes3 smooth_variance(const Planes3& variance, const Planes3* halves);

}  // namespace sheaf
