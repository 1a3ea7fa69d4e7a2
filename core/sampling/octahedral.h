// Octahedral maps: unit vectors in 32 bits, 16 per axis (Cigolle et al., "A Survey of Efficient Representations for
// Independent Unit Vectors", JCGT 2014), and the equal-area map between directions and the unit square.
#pragma once

#include "core/math/vec.h"
#include "core/sampling/warp.h"

namespace sheaf {

/// Encodes a unit vector to within 1e-4 of its direction.
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

/// Decodes the result of encode_octahedral() without normalizing it: the length lies in [0.57, 1.01]. Any 32 bits give
/// such a vector.
template <class L> SHEAF_INLINE Vec3<L> decode_octahedral_direction(typename L::Uint bits) {
  using F = typename L::Float;
  using U = typename L::Uint;
  const auto expand = [](U v) SHEAF_LAMBDA_INLINE { return (to_float(v) - F(32767.0f)) * F(1.0f / 32767.0f); };
  const F x = expand(bits & U(0xffffu)), y = expand(bits >> 16);
  const F z = F(1.0f) - abs(x) - abs(y);
  const F fold = max(-z, F(0.0f));
  return {x - copysign(fold, x), y - copysign(fold, y), z};
}

/// Decodes the result of encode_octahedral() to unit length. Any 32 bits give a unit vector.
template <class L> SHEAF_INLINE Vec3<L> decode_octahedral(typename L::Uint bits) {
  return normalize(decode_octahedral_direction<L>(bits));
}

/// Maps a unit direction to the unit square by the equal-area octahedral map (Clarberg, "Fast Equal-Area Mapping of the
/// (Hemi)Sphere using SIMD", JGT 2008). +z maps to the center, -z to all four corners, +x to (1, 1/2) and +y to (1/2,
/// 1).
template <class L> SHEAF_INLINE Vec2<L> equal_area_octahedral(Vec3<L> d) {
  using F = typename L::Float;
  const F radius = sqrt(max(F(1.0f) - abs(d.z), F(0.0f)));
  const F octant_fraction = atan2(abs(d.y), abs(d.x)) * F(2.0f * kInvPi);  // from 0 at x to 1 at y
  const F across = octant_fraction * radius, along = radius - across;
  const auto lower = d.z < F(0.0f);
  const F x = select(lower, F(1.0f) - across, along), y = select(lower, F(1.0f) - along, across);
  return {F(0.5f) * (copysign(x, d.x) + F(1.0f)), F(0.5f) * (copysign(y, d.y) + F(1.0f))};
}

/// The direction at a position in the unit square, the inverse of equal_area_octahedral().
template <class L> SHEAF_INLINE Vec3<L> equal_area_direction(typename L::Float u, typename L::Float v) {
  using F = typename L::Float;
  const F x = F(2.0f) * u - F(1.0f), y = F(2.0f) * v - F(1.0f), along = abs(x), across = abs(y);
  const F signed_distance = F(1.0f) - along - across;  // from the diamond of z = 0, positive inside
  const F radius = F(1.0f) - abs(signed_distance);
  const F octant_fraction = select(radius > F(0.0f), (across - along) / max(radius, F(1e-37f)) + F(1.0f), F(1.0f));
  const auto angle = sincos_2pi<L>(octant_fraction * F(0.125f));
  const F sine = radius * safe_sqrt(F(2.0f) - radius * radius);
  return {copysign(angle.cos * sine, x), copysign(angle.sin * sine, y),
          copysign(F(1.0f) - radius * radius, signed_distance)};
}

}  // namespace sheaf
