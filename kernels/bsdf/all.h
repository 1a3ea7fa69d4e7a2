// The list of all BSDFs and phase functions: the implementation of each closure kind in scene/tables/material.h.
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
#include "kernels/wave/wave.h"

namespace sheaf {

/// Names a BSDF template as a value.
template <template <class> class Bsdf> struct BsdfTag { template <class L> using Type = Bsdf<L>; };

namespace bsdf_detail {

template <template <class> class Bsdf> constexpr bool has_passage() {
  return requires(const Bsdf<Scalar>& bsdf) { bsdf.passage(1.0f); };
}

/// Whether a BSDF matches its ClosureEntry in for_each_closure(): parameters, number of words, thin dielectric or not.
template <template <class> class Bsdf> consteval bool fits_its_closure() {
  bool fits = false;
  for_each_closure([&]<ClosureKind Kind, template <class> class P, class D>(ClosureEntry<Kind, P, D> closure) {
    if (Kind != Bsdf<Scalar>::kKind) return;
    fits = std::is_base_of_v<P<Scalar>, Bsdf<Scalar>> && kLeafCount<P> == kLeafCount<Bsdf> &&
           kLeafCount<P> <= kMaxClosureWords && closure.is_thin_dielectric == has_passage<Bsdf>();
  });
  return fits;
}

template <template <class> class... Bsdfs> struct BsdfList {
  static_assert((fits_its_closure<Bsdfs>() && ...), "a BSDF and its entry in for_each_closure() differ");

  /// Whether every ClosureKind has a BSDF, and the list is in the order of the enumeration.
  static consteval bool is_complete() {
    int kind = 0;
    return ((static_cast<int>(Bsdfs<Scalar>::kKind) == kind++) && ...) && kind == kClosureKinds;
  }

  template <class F> static SHEAF_INLINE void for_each(F&& f) { (f(Bsdfs<Scalar>::kKind, BsdfTag<Bsdfs>{}), ...); }
};

}  // namespace bsdf_detail

/// All BSDFs, in the order of ClosureKind.
using AllBsdfs = bsdf_detail::BsdfList<
    DiffuseBsdf, ConductorBsdf, DielectricBsdf, ThinDielectricBsdf, PlasticBsdf, RoughConductorBeckmannBsdf,
    RoughConductorGgxBsdf, RoughDielectricBeckmannBsdf, RoughDielectricGgxBsdf, RoughPlasticBeckmannBsdf,
    RoughPlasticGgxBsdf, PrincipledBsdf, PrincipledThinBsdf, DisneyBsdf, NoriMicrofacetBsdf, DispersiveDielectricBsdf,
    DispersiveThinDielectricBsdf, DispersiveRoughDielectricBeckmannBsdf, DispersiveRoughDielectricGgxBsdf, PhongBsdf,
    RoughDiffuseBsdf, WardBsdf, DiffuseTransmitterBsdf, HanrahanKruegerBsdf, MeasuredBsdf, MeasuredSpectralBsdf,
    HairBsdf, CoatedBsdf, RoughCoatedBeckmannBsdf, RoughCoatedGgxBsdf, HenyeyGreensteinBsdf, RayleighBsdf,
    TabulatedPhaseBsdf, SggxBsdf>;
static_assert(AllBsdfs::is_complete(), "a closure has no BSDF, or they are not in the order of ClosureKind");

/// Calls f(kind, BsdfTag<...>) for every BSDF and phase function.
template <class F> SHEAF_INLINE void for_each_bsdf(F&& f) { AllBsdfs::for_each(f); }

/// Loads the BSDFs of the items [column, column + L::width) of the wave's closure queue.
template <class L, template <class> class Bsdf>
SHEAF_INLINE Bsdf<L> load_bsdf(const SceneView& scene, const Wave& wave, int column) {
  float* const* words = wave.closures.columns().words;
  return bsdf_of_words<Bsdf<L>>(scene.materials.closure_tables,
                                [words, column](int k, Float<L>& word)
                                    SHEAF_LAMBDA_INLINE { load(words[k] + column, word); });
}

/// Spectral mode: evaluates spectrum `k` of each lane's material at the path's wavelengths.
template <class L>
SHEAF_INLINE Spectrum<L> closure_spectrum(const SceneView& scene, Uint<L> material, int k, const Spectrum<L>& lambda) {
  const Uint<L> row = material * Uint<L>(std::uint32_t{kMaxClosureSpectra}) + Uint<L>(static_cast<std::uint32_t>(k));
  return evaluate<L>(scene.spectral.materials, row, scene.spectral.tables, lambda);
}

}  // namespace sheaf
