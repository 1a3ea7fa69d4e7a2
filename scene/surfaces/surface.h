// A surface point, common to hits on all kinds of shapes.
#pragma once

#include "core/math/frame.h"
#include "scene/tables/scene_view.h"

namespace sheaf {

/// The surface at a hit, in world space.
template <class L> struct SurfacePoint {
  Vec3<L> p;                 ///< on the surface, more accurate than origin + t * direction
  Vec3<L> ng;                ///< geometric normal, unit length
  Vec3<L> ns;                ///< interpolated normal, unit length
  typename L::Float offset;  ///< distance along +-ng at which a ray must start to avoid hitting the same surface again
  Vec2<L> uv;                ///< only with kWithUv
  /// Derivatives of the position by u and v, only with kWithUv. Never zero. If one vanishes (poles, the center of a
  /// disk), it has the right direction and a tiny length. If a triangle's uv are missing or degenerate, they are
  /// arbitrary orthonormal tangents. If a mesh has tangents, the directions of tangent and bitangent.
  Vec3<L> dp_du, dp_dv;
  /// Squared lengths of the derivatives by u and v, also if dp_du and dp_dv are tangents; infinite if unknown. Only
  /// with kWithUv.
  Vec2<L> squared_uv_lengths;
};

/// Normalizes vectors whose squared length would overflow or underflow.
template <class L> SHEAF_INLINE Vec3<L> normalize_any(Vec3<L> a) {
  const Float<L> m = max_component(abs(a));
  return normalize(a * (Float<L>(1.0f) / max(m, Float<L>(1e-37f))));
}

/// Rounding errors of positions and of Embree's arithmetic are below this many units in the last place of the
/// coordinates involved. tests/kernels/wave/test_ray_offset.cpp verifies this for shapes from 1e-3 to 1e5 units.
inline constexpr float kOffsetUlps = 8.0f * 5.9604645e-8f;

/// Selects `a` or `b` per lane.
template <class L, bool kWithUv>
SHEAF_INLINE SurfacePoint<L> select(Mask<L> m, const SurfacePoint<L>& a, const SurfacePoint<L>& b) {
  SurfacePoint<L> out;
  out.p = select<L>(m, a.p, b.p);
  out.ng = select<L>(m, a.ng, b.ng);
  out.ns = select<L>(m, a.ns, b.ns);
  out.offset = select(m, a.offset, b.offset);
  if constexpr (kWithUv) {
    out.uv = {select(m, a.uv.x, b.uv.x), select(m, a.uv.y, b.uv.y)};
    out.dp_du = select<L>(m, a.dp_du, b.dp_du);
    out.dp_dv = select<L>(m, a.dp_dv, b.dp_dv);
    out.squared_uv_lengths = {select(m, a.squared_uv_lengths.x, b.squared_uv_lengths.x),
                              select(m, a.squared_uv_lengths.y, b.squared_uv_lengths.y)};
  }
  return out;
}

}  // namespace sheaf
