// Local frames: orthonormal bases with z along the normal.
#pragma once

#include "core/math/vec.h"

namespace sheaf {

/// An orthonormal basis; `n` is the local z axis.
template <class L> struct Frame {
  Vec3<L> s, t, n;

  /// Any frame around the unit vector `n`, continuous except at n.z = 0 (Duff et al., "Building an Orthonormal Basis,
  /// Revisited", JCGT 2017, listing 3).
  static SHEAF_INLINE Frame from_normal(Vec3<L> n) {
    const Float<L> sign = copysign(Float<L>(1.0f), n.z);
    const Float<L> a = Float<L>(-1.0f) / (sign + n.z);
    const Float<L> b = n.x * n.y * a;
    return {{Float<L>(1.0f) + sign * n.x * n.x * a, sign * b, -sign * n.x}, {b, sign + n.y * n.y * a, -n.y}, n};
  }

  SHEAF_INLINE Vec3<L> to_local(Vec3<L> v) const { return {dot(s, v), dot(t, v), dot(n, v)}; }
  SHEAF_INLINE Vec3<L> to_world(Vec3<L> v) const { return s * v.x + t * v.y + n * v.z; }
};

}  // namespace sheaf
