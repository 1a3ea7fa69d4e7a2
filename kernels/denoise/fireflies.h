// Fireflies: single pixels far brighter than all around them, made by few samples.
#pragma once

#include "kernels/denoise/plane.h"

namespace sheaf {

/// Gives pixels that are fireflies the colour and the variance of an ordinary neighbour. A mean that holds one would
/// smear it into a blotch, since its variance excuses any difference. A pixel is one if its luminance is well above
/// that of all but one of its eight neighbours, and its excess over their median is not certain: `other`, the mean of
/// other samples, lacks most of it, or, where `other` is nullptr, its variance is large. Deterministic; uses threads.
void remove_fireflies(Planes3& color, Planes3& variance, const Planes3* other);

}  // namespace sheaf
