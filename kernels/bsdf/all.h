// The list of all BSDFs, phase functions among them: the one place where closure kinds and their types meet.
#pragma once

#include "kernels/bsdf/conductor.h"
#include "kernels/bsdf/dielectric.h"
#include "kernels/bsdf/diffuse.h"
#include "kernels/bsdf/disney.h"
#include "kernels/bsdf/dispersive_dielectric.h"
#include "kernels/bsdf/dispersive_rough_dielectric.h"
#include "kernels/bsdf/henyey_greenstein.h"
#include "kernels/bsdf/nori_microfacet.h"
#include "kernels/bsdf/plastic.h"
#include "kernels/bsdf/principled.h"
#include "kernels/bsdf/principled_thin.h"
#include "kernels/bsdf/rayleigh.h"
#include "kernels/bsdf/rough_conductor.h"
#include "kernels/bsdf/rough_dielectric.h"
#include "kernels/bsdf/rough_plastic.h"
#include "kernels/bsdf/thin_dielectric.h"
#include "kernels/wave.h"

namespace sheaf {

/// Names a BSDF template as a value.
template <template <class> class Bsdf> struct BsdfTag {
  template <class L> using Type = Bsdf<L>;
};

/// Calls f(kind, BsdfTag<...>) for every BSDF and phase function.
template <class F> SHEAF_INLINE void for_each_bsdf(F&& f) {
  f(ClosureKind::kDiffuse, BsdfTag<DiffuseBsdf>{});
  f(ClosureKind::kConductor, BsdfTag<ConductorBsdf>{});
  f(ClosureKind::kDielectric, BsdfTag<DielectricBsdf>{});
  f(ClosureKind::kThinDielectric, BsdfTag<ThinDielectricBsdf>{});
  f(ClosureKind::kPlastic, BsdfTag<PlasticBsdf>{});
  f(ClosureKind::kRoughConductorBeckmann, BsdfTag<RoughConductorBeckmannBsdf>{});
  f(ClosureKind::kRoughConductorGgx, BsdfTag<RoughConductorGgxBsdf>{});
  f(ClosureKind::kRoughDielectricBeckmann, BsdfTag<RoughDielectricBeckmannBsdf>{});
  f(ClosureKind::kRoughDielectricGgx, BsdfTag<RoughDielectricGgxBsdf>{});
  f(ClosureKind::kRoughPlasticBeckmann, BsdfTag<RoughPlasticBeckmannBsdf>{});
  f(ClosureKind::kRoughPlasticGgx, BsdfTag<RoughPlasticGgxBsdf>{});
  f(ClosureKind::kPrincipled, BsdfTag<PrincipledBsdf>{});
  f(ClosureKind::kPrincipledThin, BsdfTag<PrincipledThinBsdf>{});
  f(ClosureKind::kDisney, BsdfTag<DisneyBsdf>{});
  f(ClosureKind::kNoriMicrofacet, BsdfTag<NoriMicrofacetBsdf>{});
  f(ClosureKind::kDispersiveDielectric, BsdfTag<DispersiveDielectricBsdf>{});
  f(ClosureKind::kDispersiveThinDielectric, BsdfTag<DispersiveThinDielectricBsdf>{});
  f(ClosureKind::kDispersiveRoughDielectricBeckmann, BsdfTag<DispersiveRoughDielectricBeckmannBsdf>{});
  f(ClosureKind::kDispersiveRoughDielectricGgx, BsdfTag<DispersiveRoughDielectricGgxBsdf>{});
  f(ClosureKind::kHenyeyGreenstein, BsdfTag<HenyeyGreensteinBsdf>{});
  f(ClosureKind::kRayleigh, BsdfTag<RayleighBsdf>{});
}

/// The BSDFs of the items [column, column + L::width).
template <class L, template <class> class Bsdf> SHEAF_INLINE Bsdf<L> load_bsdf(const Wave& wave, int column) {
  Bsdf<L> bsdf;
  float* const* words = wave.closures.columns().words;
  std::apply(
      [words, column](auto&... leaf) SHEAF_LAMBDA_INLINE {
        int k = 0;
        (load(words[k++] + column, leaf), ...);
      },
      leaves(bsdf));
  return bsdf;
}

}  // namespace sheaf
