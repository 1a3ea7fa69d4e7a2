// The list of all BSDFs and phase functions: the implementation of each closure in scene/materials/list.h.
#pragma once

#include "kernels/bsdf/coated.h"
#include "kernels/bsdf/conductor.h"
#include "kernels/bsdf/dielectric.h"
#include "kernels/bsdf/diffuse.h"
#include "kernels/bsdf/diffuse_transmitter.h"
#include "kernels/bsdf/disney.h"
#include "kernels/bsdf/dispersive_dielectric.h"
#include "kernels/bsdf/dispersive_rough_dielectric.h"
#include "kernels/bsdf/hair.h"
#include "kernels/bsdf/hanrahan_krueger.h"
#include "kernels/bsdf/measured.h"
#include "kernels/bsdf/nori_microfacet.h"
#include "kernels/bsdf/phong.h"
#include "kernels/bsdf/plastic.h"
#include "kernels/bsdf/principled.h"
#include "kernels/bsdf/principled_thin.h"
#include "kernels/bsdf/rough_coated.h"
#include "kernels/bsdf/rough_conductor.h"
#include "kernels/bsdf/rough_dielectric.h"
#include "kernels/bsdf/rough_diffuse.h"
#include "kernels/bsdf/rough_plastic.h"
#include "kernels/bsdf/thin_dielectric.h"
#include "kernels/bsdf/ward.h"
#include "kernels/phase/henyey_greenstein.h"
#include "kernels/phase/rayleigh.h"
#include "kernels/phase/sggx.h"
#include "kernels/phase/tabulated_phase.h"
#include "scene/materials/list.h"
#include "scene/tables/scene.h"

namespace sheaf {

/// The ClosureKind of a BSDF.
template <class Bsdf> inline constexpr ClosureKind kKindOf = kClosureKind<typename Bsdf::Closure>;

/// Names a BSDF template as a value.
template <template <class> class Bsdf> struct BsdfTag { template <class L> using Type = Bsdf<L>; };

namespace bsdf_detail {

template <template <class> class Bsdf> constexpr bool has_passage() {
  return requires(const Bsdf<Scalar>& bsdf) { bsdf.passage(1.0f); };
}

/// Whether a BSDF matches its closure: parameters, number of words, thin dielectric or not.
template <template <class> class Bsdf> consteval bool fits_its_closure() {
  using Closure = typename Bsdf<Scalar>::Closure;
  return std::is_base_of_v<typename Closure::template Parameters<Scalar>, Bsdf<Scalar>> &&
         kLeafCount<Closure::template Parameters> == kLeafCount<Bsdf> && kLeafCount<Bsdf> <= kMaxClosureWords &&
         Closure::kInfo.is_thin_dielectric == has_passage<Bsdf>();
}

/// Whether a coat has room for the parameters of a BSDF. It does not pass on the scene's tables.
template <template <class> class Bsdf> consteval bool fits_below_coat() {
  constexpr int kSpectra = closure_spectra<Bsdf>().count;
  return !kHasTables<Bsdf<Scalar>> && kSpectra <= kCoatableSpectra &&
         kLeafCount<Bsdf> - 4 * kSpectra <= kCoatableNumbers;
}

template <template <class> class... Bsdfs> struct BsdfList {
  static_assert((fits_its_closure<Bsdfs>() && ...), "a BSDF differs from its closure in scene/materials/");
  static_assert(((!Bsdfs<Scalar>::Closure::kInfo.is_coatable || fits_below_coat<Bsdfs>()) && ...),
                "a coatable closure has more parameters than a coat can hold");

  /// Number of BSDFs with this closure.
  template <class Closure> static consteval int count() {
    return (int{std::is_same_v<Closure, typename Bsdfs<Scalar>::Closure>} + ...);
  }
  /// Whether every closure has one BSDF, and no BSDF is left.
  template <class... Closures> static consteval bool implements(ClosureList<Closures...>) {
    return ((count<Closures>() == 1) && ...) && sizeof...(Closures) == sizeof...(Bsdfs);
  }

  template <class F> static SHEAF_INLINE void for_each(F&& f) { (f(kKindOf<Bsdfs<Scalar>>, BsdfTag<Bsdfs>{}), ...); }
};

}  // namespace bsdf_detail

/// All BSDFs.
using AllBsdfs = bsdf_detail::BsdfList<
    DiffuseBsdf, ConductorBsdf, DielectricBsdf, ThinDielectricBsdf, PlasticBsdf, RoughConductorBeckmannBsdf,
    RoughConductorGgxBsdf, RoughDielectricBeckmannBsdf, RoughDielectricGgxBsdf, RoughPlasticBeckmannBsdf,
    RoughPlasticGgxBsdf, PrincipledBsdf, PrincipledThinBsdf, DisneyBsdf, NoriMicrofacetBsdf, DispersiveDielectricBsdf,
    DispersiveThinDielectricBsdf, DispersiveRoughDielectricBeckmannBsdf, DispersiveRoughDielectricGgxBsdf, PhongBsdf,
    RoughDiffuseBsdf, WardBsdf, DiffuseTransmitterBsdf, HanrahanKruegerBsdf, MeasuredBsdf, MeasuredSpectralBsdf,
    HairBsdf, CoatedBsdf, RoughCoatedBeckmannBsdf, RoughCoatedGgxBsdf, HenyeyGreensteinBsdf, RayleighBsdf,
    TabulatedPhaseBsdf, SggxBsdf>;
static_assert(AllBsdfs::implements(AllClosures{}), "a closure in scene/materials/list.h has no BSDF, or several");

/// Calls f(kind, BsdfTag<...>) for every BSDF and phase function.
template <class F> SHEAF_INLINE void for_each_bsdf(F&& f) { AllBsdfs::for_each(f); }

/// Calls f(kind, BsdfTag<...>) for every BSDF that a coat can cover.
template <class F> SHEAF_INLINE void for_each_coatable_bsdf(F&& f) {
  for_each_bsdf([&]<template <class> class Bsdf>(ClosureKind kind, BsdfTag<Bsdf> bsdf) SHEAF_LAMBDA_INLINE {
    if constexpr (Bsdf<Scalar>::Closure::kInfo.is_coatable) f(kind, bsdf);
  });
}

/// Spectral mode: evaluates spectrum `k` of each lane's material at the path's wavelengths.
template <class L>
SHEAF_INLINE Spectrum<L> closure_spectrum(const SceneView& scene, Uint<L> material, int k, const Spectrum<L>& lambda) {
  const Uint<L> row = material * Uint<L>(std::uint32_t{kMaxClosureSpectra}) + Uint<L>(static_cast<std::uint32_t>(k));
  return evaluate<L>(scene.spectral.materials, row, scene.spectral.tables, lambda);
}

}  // namespace sheaf
