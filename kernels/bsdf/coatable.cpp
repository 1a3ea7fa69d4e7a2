// Dispatch to the BSDF below a coat, by its kind.
#include "kernels/bsdf/coatable.h"

#include "core/soa/lane_array.h"
#include "kernels/bsdf/list.h"

#include <bit>

namespace sheaf {

namespace {

/// Unpacks the BSDF of type Bsdf from the parameters of the coat.
template <class L, template <class> class Bsdf> SHEAF_INLINE Bsdf<L> nested_bsdf(const CoatedParameters<L>& coat) {
  return bsdf_of_words<Bsdf<L>>(nullptr, [&coat](int k, Float<L>& word) SHEAF_LAMBDA_INLINE {
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

/// Calls f.operator()<Bsdf>(bsdf, lanes) for each closure kind below the coats in the register.
template <class L, class F> SHEAF_INLINE void for_each_nested(const CoatedParameters<L>& coat, F&& f) {
  const LaneArray<Uint<L>> kinds(coat.nested_kind);
  Mask<L> left(true);
  while (any(left)) {
    const std::uint32_t kind = kinds[std::countr_zero(mask_bits(left))];
    const auto same = left & (coat.nested_kind == Uint<L>(kind));
    // Lanes beyond the end of a run may hold any value.
    if (kind < std::uint32_t{kClosureKinds})
      for_each_coatable_bsdf([&]<template <class> class Bsdf>(ClosureKind each, BsdfTag<Bsdf>) SHEAF_LAMBDA_INLINE {
        if (each == static_cast<ClosureKind>(kind)) f(nested_bsdf<L, Bsdf>(coat), same);
      });
    left = left & !same;
  }
}

}  // namespace

template <class L> BsdfValue<L> evaluate_nested(const CoatedParameters<L>& coat, Vec3<L> wo, Vec3<L> wi) noexcept {
  BsdfValue<L> out{Spectrum<L>(Float<L>(0.0f)), Float<L>(0.0f)};
  for_each_nested<L>(coat, [&](const auto& bsdf, Mask<L> lanes) {
    const BsdfValue<L> value = bsdf.evaluate(wo, wi);
    out.f_cos = select<L>(lanes, value.f_cos, out.f_cos);
    out.pdf_solid_angle = select(lanes, value.pdf_solid_angle, out.pdf_solid_angle);
  });
  return out;
}

template <class L>
BsdfSample<L> sample_nested(const CoatedParameters<L>& coat, Vec3<L> wo, const Random4<L>& u) noexcept {
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

template BsdfValue<Wide> evaluate_nested(const CoatedParameters<Wide>&, Vec3<Wide>, Vec3<Wide>) noexcept;
template BsdfValue<Scalar> evaluate_nested(const CoatedParameters<Scalar>&, Vec3<Scalar>, Vec3<Scalar>) noexcept;
template BsdfSample<Wide> sample_nested(const CoatedParameters<Wide>&, Vec3<Wide>, const Random4<Wide>&) noexcept;
template BsdfSample<Scalar> sample_nested(const CoatedParameters<Scalar>&, Vec3<Scalar>,
                                          const Random4<Scalar>&) noexcept;

}  // namespace sheaf
