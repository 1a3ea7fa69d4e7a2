// All BSDFs and phase functions: the implementations (BsdfOf) of the closures in scene/materials/list.h. CMake collects
// their headers.
#pragma once

#include "kernels/bsdf/all_headers.h"
#include "kernels/bsdf/bsdf.h"
#include "kernels/phase/all_headers.h"
#include "scene/materials/list.h"
#include "scene/tables/scene_view.h"

namespace sheaf {

/// The ClosureKind of a BSDF.
template <class Bsdf> inline constexpr ClosureKind kKindOf = kClosureKind<typename Bsdf::Closure>;

namespace bsdf_detail {

template <class Bsdf> constexpr bool has_passage() {
  return requires(const Bsdf& bsdf) { bsdf.passage(1.0f); };
}

/// Whether a BSDF matches its closure: parameters, number of words, thin dielectric or not.
template <class Closure, template <class> class Bsdf> consteval bool fits(BsdfTag<Bsdf>) {
  return std::is_same_v<typename Bsdf<Scalar>::Closure, Closure> &&
         std::is_base_of_v<typename Closure::template Parameters<Scalar>, Bsdf<Scalar>> &&
         kLeafCount<Closure::template Parameters> == kLeafCount<Bsdf> && kLeafCount<Bsdf> <= kMaxClosureWords &&
         Closure::kInfo.is_thin_dielectric == has_passage<Bsdf<Scalar>>();
}

/// Whether a coat has room for the parameters of a BSDF. It does not pass on the scene's tables.
template <template <class> class Bsdf> consteval bool fits_below_coat(BsdfTag<Bsdf>) {
  constexpr int kSpectra = closure_spectra<Bsdf>().count;
  return !kHasTables<Bsdf<Scalar>> && kSpectra <= kCoatableSpectra &&
         kLeafCount<Bsdf> - 4 * kSpectra <= kCoatableNumbers;
}

template <class Closure>
concept Implemented = requires {
  sizeof(BsdfOf<Closure>);
};

template <class List> struct BsdfList;
template <class... Closures> struct BsdfList<ClosureList<Closures...>> {
  static_assert(
      (Implemented<Closures> && ...),
      "a closure in scene/materials/list.h has no BSDF: no header begins a line with 'template <> struct BsdfOf<'");
  static_assert((fits<Closures>(BsdfOf<Closures>{}) && ...), "a BSDF differs from its closure in scene/materials/");
  static_assert(((!Closures::kInfo.is_coatable || fits_below_coat(BsdfOf<Closures>{})) && ...),
                "a coatable closure has more parameters than a coat can hold");

  template <class F> static SHEAF_INLINE void for_each(F&& f) { (f(kClosureKind<Closures>, BsdfOf<Closures>{}), ...); }
};

}  // namespace bsdf_detail

/// All BSDFs, by closure.
using AllBsdfs = bsdf_detail::BsdfList<AllClosures>;

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
