// Smoothing of variances for use as divisors.
#pragma once

#include "kernels/denoise/plane.h"

namespace sheaf {

/// Smooths variances, which are as noisy as the image itself if they come from few sets of samples. The result is the
/// mean over 3 x 3 pixels, but at least a fraction of a pixel's own variance. The mean excludes pixels that both halves
/// show more than twice as bright as either half shows this pixel. Such a pixel shows another object, for example a
/// lamp, with unrelated noise. `halves`: means of two sets of samples, or nullptr. The result has extended borders.
/// Deterministic and multithreaded.
Planes3 smooth_variance(const Planes3& variance, const Planes3* halves);

}  // namespace sheaf
