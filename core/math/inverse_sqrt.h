// Inverse square roots without division, which take a fraction of the time of 1 / sqrt(x) in wide registers.
#pragma once

#include "core/math/vec.h"

namespace sheaf {

/// 1 / sqrt(x) for positive x away from the ends of the range, relative error below 1.7e-5. Gives the same bits in all
/// lanes. An estimate g from the exponent is multiplied by a minimax polynomial in x g^2. A square root with a division
/// takes longer, and so do two Newton steps.
template <class L> SHEAF_INLINE Float<L> rough_inverse_sqrt(typename L::Float x) {
  using F = Float<L>;
  const F guess = bits_float(Uint<L>(0x5f200000u) - (float_bits(x) >> 1)), r = x * guess * guess;
  return guess * fma(fma(F(0.6630861f), r, F(-1.76082021f)), r, F(2.10231116f));
}

/// 1 / sqrt(x) for positive x away from the ends of the range, relative error below 3e-7.
template <class L> SHEAF_INLINE Float<L> inverse_sqrt(typename L::Float x) {
  using F = Float<L>;
  const F rough = rough_inverse_sqrt<L>(x);
  // One Newton step
  return rough * fma(x * F(-0.5f) * rough, rough, F(1.5f));
}

}  // namespace sheaf
