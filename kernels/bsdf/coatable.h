// Evaluation and sampling of the closure below a coat: any opaque closure that is not itself a coat. Its kind is a
// parameter of the coat, so all coated materials share one closure kind and uncoated ones have no overhead.
// coatable.cpp dispatches over the kinds that occur in one register.
#pragma once

#include "kernels/bsdf/bsdf.h"
#include "scene/materials/coat.h"

namespace sheaf {

/// evaluate() of the base, for directions inside the coat. Compiled once for all users: the many BSDFs are a lot of
/// code, and few coats occur in a register.
template <class L> BsdfValue<L> evaluate_nested(const CoatedParameters<L>& coat, Vec3<L> wo, Vec3<L> wi) noexcept;

/// sample() of the base, for directions inside the coat. Compiled once, as evaluate_nested().
template <class L>
BsdfSample<L> sample_nested(const CoatedParameters<L>& coat, Vec3<L> wo, const Random4<L>& u) noexcept;

}  // namespace sheaf
