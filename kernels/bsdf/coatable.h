// What lies below a coat: any closure that is opaque and no coat itself. Its kind is one of the coat's parameters, so
// that all that is coated is one closure of its own, and nothing else pays for it; the kinds that share a register are
// told apart here.
#pragma once

#include "kernels/bsdf/conductor.h"
#include "kernels/bsdf/diffuse.h"
#include "kernels/bsdf/disney.h"
#include "kernels/bsdf/nori_microfacet.h"
#include "kernels/bsdf/phong.h"
#include "kernels/bsdf/plastic.h"
#include "kernels/bsdf/principled.h"
#include "kernels/bsdf/rough_conductor.h"
#include "kernels/bsdf/rough_diffuse.h"
#include "kernels/bsdf/rough_plastic.h"
#include "kernels/bsdf/ward.h"

#include <bit>

namespace sheaf {

namespace coat_detail {

template <template <class> class... Bsdfs> struct CoatableList {
  /// Calls f.operator()<Bsdf>() for the BSDF of that kind, if it is in the list.
  template <class F> static SHEAF_INLINE void visit(ClosureKind kind, F&& f) {
    ((Bsdfs<Scalar>::kKind == kind ? f.template operator()<Bsdfs>() : void()), ...);
  }
  /// Calls f.operator()<Bsdf>() for all.
  template <class F> static constexpr void for_each(F&& f) { (f.template operator()<Bsdfs>(), ...); }
  static constexpr bool holds(ClosureKind kind) { return ((Bsdfs<Scalar>::kKind == kind) || ...); }
  static_assert(((closure_spectra<Bsdfs>().count <= kCoatableSpectra &&
                  kLeafCount<Bsdfs> - 4 * closure_spectra<Bsdfs>().count <= kCoatableNumbers) &&
                 ...),
                "a closure has more parameters than a coat has room for");
};

}  // namespace coat_detail

/// All BSDFs that can be coated; those whose ClosureEntry says so.
using CoatableBsdfs =
    coat_detail::CoatableList<DiffuseBsdf, ConductorBsdf, PlasticBsdf, RoughConductorBeckmannBsdf,
                              RoughConductorGgxBsdf, RoughPlasticBeckmannBsdf, RoughPlasticGgxBsdf, PrincipledBsdf,
                              DisneyBsdf, NoriMicrofacetBsdf, PhongBsdf, RoughDiffuseBsdf, WardBsdf>;
static_assert(
    [] {
      for (int kind = 0; kind < kClosureKinds; ++kind)
        if (CoatableBsdfs::holds(static_cast<ClosureKind>(kind)) !=
            kClosureInfos[static_cast<std::size_t>(kind)].is_coatable)
          return false;
      return true;
    }(),
    "what can be coated is in CoatableBsdfs and says so in for_each_closure()");

/// The closure of type Bsdf below a coat.
template <class L, template <class> class Bsdf> SHEAF_INLINE Bsdf<L> nested_bsdf(const CoatedParameters<L>& coat) {
  return bsdf_of_words<Bsdf<L>>([&coat](int k, Float<L>& word) SHEAF_LAMBDA_INLINE {
    const int at = coated_word<Bsdf>(k), number = at - 4 * kCoatableSpectra;
    if (number >= 0) {
      word = coat.nested_numbers[number];
      return;
    }
    const Spectrum<L>& s = coat.nested_spectra[at / 4];
    const Float<L> channels[4] = {s.c0, s.c1, s.c2, s.c3};
    word = channels[at % 4];
  });
}

/// Calls f.operator()<Bsdf>(bsdf, lanes) for each kind of closure below the coats of a register.
template <class L, class F> SHEAF_INLINE void for_each_nested(const CoatedParameters<L>& coat, F&& f) {
  alignas(kSimdAlignment) float kinds[L::width];
  store(kinds, coat.nested_kind);
  Mask<L> left(true);
  while (any(left)) {
    const float kind = kinds[std::countr_zero(mask_bits(left))];
    const auto same = left & (float_bits(coat.nested_kind) == Uint<L>(float_bits(kind)));
    // Lanes behind a run's end may hold anything.
    if (kind >= 0.0f && kind < static_cast<float>(kClosureKinds))
      CoatableBsdfs::visit(static_cast<ClosureKind>(static_cast<int>(kind)),
                           [&]<template <class> class Bsdf>() { f(nested_bsdf<L, Bsdf>(coat), same); });
    left = left & !same;
  }
}

/// evaluate() of what is coated, for directions within the coat.
template <class L>
[[gnu::noinline]] BsdfValue<L> evaluate_nested(const CoatedParameters<L>& coat, Vec3<L> wo, Vec3<L> wi) {
  BsdfValue<L> out{Spectrum<L>(Float<L>(0.0f)), Float<L>(0.0f)};
  for_each_nested<L>(coat, [&](const auto& bsdf, Mask<L> lanes) {
    const BsdfValue<L> value = bsdf.evaluate(wo, wi);
    out.f_cos = select<L>(lanes, value.f_cos, out.f_cos);
    out.pdf_solid_angle = select(lanes, value.pdf_solid_angle, out.pdf_solid_angle);
  });
  return out;
}

/// sample() of what is coated, likewise.
template <class L>
[[gnu::noinline]] BsdfSample<L> sample_nested(const CoatedParameters<L>& coat, Vec3<L> wo, const Random4<L>& u) {
  using F = Float<L>;
  BsdfSample<L> out{wo, Spectrum<L>(F(0.0f)), F(0.0f), F(1.0f), Mask<L>(false)};
  for_each_nested<L>(coat, [&](const auto& bsdf, Mask<L> lanes) {
    const BsdfSample<L> s = bsdf.sample(wo, u);
    out.wi = select<L>(lanes, s.wi, out.wi);
    out.weight = select<L>(lanes, s.weight, out.weight);
    out.pdf_solid_angle = select(lanes, s.pdf_solid_angle, out.pdf_solid_angle);
    out.valid = select(lanes, s.valid, out.valid);
  });
  return out;
}

}  // namespace sheaf
