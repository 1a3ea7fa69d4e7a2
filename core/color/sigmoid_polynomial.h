// Sigmoid polynomials: smooth spectra between 0 and 1 with three coefficients.
#pragma once

#include "core/color/spectrum.h"

namespace sheaf {

/// Wavelengths are mapped from nm to [-1, 1] first, which keeps the coefficients of a polynomial at one magnitude.
inline constexpr float kSigmoidCenter = 595.0f, kSigmoidHalfRange = 235.0f;

/// The spectrum sigmoid(c0 t^2 + c1 t + c2) with t = (lambda - kSigmoidCenter) / kSigmoidHalfRange (Jakob and Hanika,
/// "A Low-Dimensional Function Space for Efficient Spectral Upsampling", Eurographics 2019).
template <class L> struct SigmoidPolynomial {
  typename L::Float c0{}, c1{}, c2{};
  static constexpr auto fields(auto& s) { return std::tie(s.c0, s.c1, s.c2); }
};

/// 1/2 + x / (2 sqrt(1 + x^2)), in [0, 1], without the cancellation of this formula for x << 0. Infinite x gives
/// exactly 0 or 1.
template <class F> SHEAF_INLINE F sigmoid(F x) {
  const F root = sqrt(fma(x, x, F(1.0f)));
  const F tail = F(0.5f) / (root * (root + abs(x)));
  return select(x < F(0.0f), tail, F(1.0f) - tail);
}

/// The inverse of sigmoid() for `value` in [0, 1]; infinite at both ends.
template <class F> SHEAF_INLINE F inverse_sigmoid(F value) {
  return (value - F(0.5f)) / sqrt(value * (F(1.0f) - value));
}

/// The spectrum at `lambda` nm.
template <class L> SHEAF_INLINE Float<L> evaluate(const SigmoidPolynomial<L>& p, typename L::Float lambda) {
  using F = typename L::Float;
  const F t = fma(lambda, F(1.0f / kSigmoidHalfRange), F(-kSigmoidCenter / kSigmoidHalfRange));
  return sigmoid(fma(fma(p.c0, t, p.c1), t, p.c2));
}

template <class L> SHEAF_INLINE Spectrum<L> evaluate(const SigmoidPolynomial<L>& p, const Spectrum<L>& lambda) {
  return {evaluate(p, lambda.c0), evaluate(p, lambda.c1), evaluate(p, lambda.c2), evaluate(p, lambda.c3)};
}

}  // namespace sheaf
