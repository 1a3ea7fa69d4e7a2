// Unit vectors in 32 bits: the octahedral map (Cigolle et al., "A Survey of Efficient Representations for Independent
// Unit Vectors", JCGT 2014), 16 bits an axis.
#pragma once

#include "core/vec.h"

namespace sheaf {

/// A unit vector to within 1e-4 of its direction.
template <class L> SHEAF_INLINE typename L::Uint encode_octahedral(Vec3<L> n) {
  using F = typename L::Float;
  const F inverse = F(1.0f) / (abs(n.x) + abs(n.y) + abs(n.z));
  const F x = n.x * inverse, y = n.y * inverse;
  const auto lower = n.z < F(0.0f);
  const F folded_x = select(lower, copysign(F(1.0f) - abs(y), x), x);
  const F folded_y = select(lower, copysign(F(1.0f) - abs(x), y), y);
  const auto quantize = [](F v) SHEAF_LAMBDA_INLINE {
    return to_uint(clamp(fma(v, F(32767.0f), F(32767.5f)), F(0.0f), F(65535.0f)));
  };
  return quantize(folded_x) | (quantize(folded_y) << 16);
}

/// The vector of encode_octahedral, unit length; a unit vector for any 32 bits.
template <class L> SHEAF_INLINE Vec3<L> decode_octahedral(typename L::Uint bits) {
  using F = typename L::Float;
  using U = typename L::Uint;
  const auto expand = [](U v) SHEAF_LAMBDA_INLINE { return (to_float(v) - F(32767.0f)) * F(1.0f / 32767.0f); };
  const F x = expand(bits & U(0xffffu)), y = expand(bits >> 16);
  const F z = F(1.0f) - abs(x) - abs(y);
  const F fold = max(-z, F(0.0f));
  return normalize(Vec3<L>{x - copysign(fold, x), y - copysign(fold, y), z});
}

}  // namespace sheaf
