// How light found by light sampling and light found by BSDF sampling are weighted against each other; see resample.cpp.
#pragma once

#include "core/lanes.h"

namespace sheaf {

/// Power heuristic (Veach 1997, equation 9.13, exponent 2): the weight of a sample drawn with density `a` where the
/// other technique has density `b`. Any finite a > 0, b >= 0.
template <class F> SHEAF_INLINE F power_heuristic(F a, F b) {
  const F ratio = b / a;
  return F(1.0f) / (F(1.0f) + ratio * ratio);
}

/// The share of light sampling: `candidates` of density `light_pdf` > 0 each, against one BSDF sample of `bsdf_pdf`.
template <class F> SHEAF_INLINE F light_weight(F light_pdf, F bsdf_pdf, int candidates) {
  return power_heuristic(light_pdf * F(static_cast<float>(candidates)), bsdf_pdf);
}

/// The share of BSDF sampling, with `bsdf_pdf` > 0: one less light_weight().
template <class F> SHEAF_INLINE F bsdf_weight(F light_pdf, F bsdf_pdf, int candidates) {
  return power_heuristic(bsdf_pdf, light_pdf * F(static_cast<float>(candidates)));
}

}  // namespace sheaf
