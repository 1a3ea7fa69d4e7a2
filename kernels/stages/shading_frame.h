// The shading frame of a vertex, in which BSDFs take their directions (PBR 9.1.1).
#pragma once

#include "core/math/frame.h"
#include "kernels/wave/path_state.h"

namespace sheaf {

/// The x axis of a frame, along dp_du: cosine and sine of its angle to the x axis of Frame::from_normal().
template <class L> SHEAF_INLINE Vec2<L> tangent_of(const Frame<L>& frame, Vec3<L> dp_du) {
  using F = Float<L>;
  const F x = dot(frame.s, dp_du), y = dot(frame.t, dp_du);
  const F squared = x * x + y * y;
  const auto usable = squared > F(0.0f);
  const F scale = F(1.0f) / sqrt(select(usable, squared, F(1.0f)));
  return {select(usable, x * scale, F(1.0f)), select(usable, y * scale, F(0.0f))};
}

/// -1 where tangent, bitangent and normal are left-handed, otherwise 1. The shading frame is right-handed: angles from
/// the tangent towards the bitangent have this sign in it.
template <class L> SHEAF_INLINE Float<L> handedness_of(Vec3<L> n, Vec3<L> dp_du, Vec3<L> dp_dv) {
  using F = Float<L>;
  return select(dot(cross(n, dp_du), dp_dv) < F(0.0f), F(-1.0f), F(1.0f));
}

/// Shading frame of a vertex: z along the shading normal; x along the tangent if `kWithTangent`, otherwise arbitrary.
template <class L, bool kWithTangent> struct ShadingFrame {
  Frame<L> frame;
  Vec2<L> tangent;

  explicit SHEAF_INLINE ShadingFrame(const VertexItem<L>& item)
      : frame(Frame<L>::from_normal(item.ns)), tangent(item.tangent) {}
  SHEAF_INLINE ShadingFrame(Vec3<L> ns, Vec2<L> t) : frame(Frame<L>::from_normal(ns)), tangent(t) {}

  SHEAF_INLINE Vec3<L> to_local(Vec3<L> v) const {
    const Vec3<L> w = frame.to_local(v);
    if constexpr (!kWithTangent) return w;
    return {w.x * tangent.x + w.y * tangent.y, w.y * tangent.x - w.x * tangent.y, w.z};
  }
  SHEAF_INLINE Vec3<L> to_world(Vec3<L> v) const {
    if constexpr (!kWithTangent) return frame.to_world(v);
    return frame.to_world({v.x * tangent.x - v.y * tangent.y, v.x * tangent.y + v.y * tangent.x, v.z});
  }
};

}  // namespace sheaf
