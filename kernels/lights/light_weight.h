// MIS weights of light sampling and BSDF sampling; see kernels/stages/resample.cpp.
#pragma once

#include "core/simd/lanes.h"

namespace sheaf {

/// Power heuristic (Veach 1997, equation 9.13, exponent 2): weight of a sample with pdf `a` if the other technique has
/// pdf `b`. Requires finite a > 0 and b >= 0.
template <class F> SHEAF_INLINE F power_heuristic(F a, F b) {
  const F ratio = b / a;
  return F(1.0f) / (F(1.0f) + ratio * ratio);
}

/// Weight of light sampling, with `candidates` samples of pdf `light_pdf` > 0 each and one BSDF sample of pdf
/// `bsdf_pdf`.
template <class F> SHEAF_INLINE F light_weight(F light_pdf, F bsdf_pdf, int candidates) {
  return power_heuristic(light_pdf * F(static_cast<float>(candidates)), bsdf_pdf);
}

/// Weight of BSDF sampling, with `bsdf_pdf` > 0: 1 - light_weight().
template <class F> SHEAF_INLINE F bsdf_weight(F light_pdf, F bsdf_pdf, int candidates) {
  return power_heuristic(bsdf_pdf, light_pdf * F(static_cast<float>(candidates)));
}

}  // namespace sheaf
