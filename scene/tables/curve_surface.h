// Surface interaction of round curves, generic in the lane policy.
#pragma once

#include "scene/tables/surface.h"

namespace sheaf {

namespace detail {

/// The axis of a tube at a parameter of one segment.
template <class L> struct CurveAxis {
  Vec3<L> p, dp;                ///< position and its derivative by the parameter
  typename L::Float r, dr;      ///< radius and its derivative by the parameter
  Vec3<L> ddp;                  ///< second derivative of the position; 0 for lines
  typename L::Float t, extent;  ///< the parameter; the largest coordinate of the segment
};

/// Normalises `a`; `default_value` if its length is zero.
template <class L> SHEAF_INLINE Vec3<L> normalize_or(Vec3<L> a, Vec3<L> default_value) {
  using F = typename L::Float;
  const F m = max_component(abs(a));
  const auto usable = m > F(1e-30f);
  return select<L>(usable, normalize(select<L>(usable, a * (F(1.0f) / max(m, F(1e-30f))), default_value)),
                   default_value);
}

/// Axis of a line segment at the t whose sphere touches the cone at `hit`: (hit - p(t)) . dp = -r(t) dr.
template <class L> SHEAF_INLINE CurveAxis<L> linear_axis(const CurvePointRecord<L>* q, Vec3<L> hit) {
  using F = typename L::Float;
  CurveAxis<L> out;
  out.dp = q[1].position - q[0].position;
  out.dr = q[1].radius - q[0].radius;
  const F slant = dot(out.dp, out.dp) - out.dr * out.dr;  // not positive: one end's sphere contains the other
  const F along = dot(hit - q[0].position, out.dp) + q[0].radius * out.dr;
  const F larger = select(out.dr > F(0.0f), F(1.0f), F(0.0f));
  const auto cone = slant > F(0.0f);
  out.t = select(cone, clamp(along / select(cone, slant, F(1.0f)), F(0.0f), F(1.0f)), larger);
  out.p = q[0].position + out.dp * out.t;
  out.r = q[0].radius + out.dr * out.t;
  out.ddp = {F(0.0f), F(0.0f), F(0.0f)};
  return out;
}

/// Axis of a uniform cubic B-spline at t.
template <class L> SHEAF_INLINE CurveAxis<L> bspline_axis(const CurvePointRecord<L>* q, typename L::Float t) {
  using F = typename L::Float;
  const F s = F(1.0f) - t, sixth(1.0f / 6.0f), half(0.5f);
  const F weights[3][4] = {{s * s * s * sixth, (F(4.0f) - t * t * (F(6.0f) - F(3.0f) * t)) * sixth,
                            (F(4.0f) - s * s * (F(6.0f) - F(3.0f) * s)) * sixth, t * t * t * sixth},
                           {-s * s * half, t * (F(1.5f) * t - F(2.0f)), -s * (F(1.5f) * s - F(2.0f)), t * t * half},
                           {s, F(3.0f) * t - F(2.0f), F(3.0f) * s - F(2.0f), t}};
  const auto point = [&](int k) SHEAF_LAMBDA_INLINE {
    const F* w = weights[k];
    return q[0].position * w[0] + q[1].position * w[1] + q[2].position * w[2] + q[3].position * w[3];
  };
  const auto radius = [&](int k) SHEAF_LAMBDA_INLINE {
    const F* w = weights[k];
    return q[0].radius * w[0] + q[1].radius * w[1] + q[2].radius * w[2] + q[3].radius * w[3];
  };
  CurveAxis<L> out;
  out.p = point(0), out.dp = point(1), out.ddp = point(2);
  out.r = radius(0), out.dr = radius(1);
  out.t = t;
  return out;
}

/// Axis of the segment that was hit.
template <class L>
SHEAF_INLINE CurveAxis<L> curve_axis(const SceneView& scene, const ShapeRecord<L>& shape, Mask<L> active,
                                     typename L::Uint primitive, typename L::Float u, Vec3<L> hit) {
  using F = typename L::Float;
  using U = typename L::Uint;
  const auto spline = active & (shape.kind == U(static_cast<std::uint32_t>(ShapeKind::kBsplineCurves)));
  const U zero(0u);
  const U first = gather(scene.geometry.curve_segments, select(active, shape.first_triangle + primitive, zero));
  CurvePointRecord<L> q[4];
  F extent(0.0f);
  for (std::uint32_t k = 0; k < 4; ++k) {
    const auto there = k < 2 ? active : spline;
    q[k] = gather_rows<L>(scene.geometry.curve_points, select(there, shape.first_vertex + first + U(k), zero));
    extent = max(extent, select(there, max_component(abs(q[k].position)) + q[k].radius, F(0.0f)));
  }
  CurveAxis<L> out = linear_axis<L>(q, hit);
  if (any(spline)) {
    const CurveAxis<L> smooth = bspline_axis<L>(q, u);
    out = {select<L>(spline, smooth.p, out.p),
           select<L>(spline, smooth.dp, out.dp),
           select(spline, smooth.r, out.r),
           select(spline, smooth.dr, out.dr),
           select<L>(spline, smooth.ddp, out.ddp),
           select(spline, smooth.t, out.t),
           extent};
  }
  out.extent = extent;
  return out;
}

/// Two directions perpendicular to `axis` for measuring angles. `sine` is as close as possible to +z, or to +y if the
/// axis is along z.
template <class L> SHEAF_INLINE void curve_frame(Vec3<L> axis, Vec3<L>& cosine, Vec3<L>& sine) {
  using F = typename L::Float;
  const Vec3<L> z{F(0.0f), F(0.0f), F(1.0f)}, y{F(0.0f), F(1.0f), F(0.0f)};
  const Vec3<L> across = z - axis * axis.z;
  sine = select<L>(dot(across, across) > F(1e-12f), normalize_or<L>(across, y), y);
  cosine = cross(sine, axis);
}

}  // namespace detail

/// Offset of rays that leave a curve, in radii: Embree finds hits on splines by iteration.
inline constexpr float kCurveOffset = 1e-3f;

/// Surface point of a curve at a hit, with `u` along the segment and `hit` near it. Splines sweep a circle
/// perpendicular to the axis; lines sweep a sphere. Not inlined: curves are rare.
template <class L, bool kWithUv>
[[gnu::noinline]] SurfacePoint<L> curve_point(const SceneView& scene, const ShapeRecord<L>& shape, Mask<L> active,
                                              Uint<L> primitive, Float<L> u, Vec3<L> hit) {
  using F = typename L::Float;
  using U = typename L::Uint;
  const detail::CurveAxis<L> axis = detail::curve_axis<L>(scene, shape, active, primitive, u, hit);
  const auto spline = shape.kind == U(static_cast<std::uint32_t>(ShapeKind::kBsplineCurves));
  const Vec3<L> z{F(0.0f), F(0.0f), F(1.0f)};
  const Vec3<L> tangent = detail::normalize_or<L>(axis.dp, z);
  const auto frame = Frame<L>::from_normal(tangent);
  const Vec3<L> from = hit - axis.p;
  const Vec3<L> away = detail::normalize_or<L>(from - tangent * select(spline, dot(from, tangent), F(0.0f)), frame.s);
  // The derivative of p + r away along a spline is `along`. The normal is the part of `away` perpendicular to it.
  const F speed = length(axis.dp), bend = max(speed * speed - axis.r * dot(away, axis.ddp), speed * speed * F(1e-3f));
  const Vec3<L> slanted = away * bend - axis.dp * axis.dr;
  SurfacePoint<L> out;
  out.p = axis.p + away * axis.r;
  out.ng = out.ns = select<L>(spline, detail::normalize_or<L>(slanted, away), away);
  out.offset = F(kOffsetUlps) * F(4.0f) * axis.extent + F(kCurveOffset) * axis.r;
  if constexpr (kWithUv) {
    const F count = to_float(select(active, shape.triangle_count, U(1u)));
    Vec3<L> cosine, sine;
    detail::curve_frame<L>(tangent, cosine, sine);
    const F turn = atan2(dot(away, sine), dot(away, cosine)) * F(0.5f * kInvPi);
    out.uv = {select(turn < F(0.0f), turn + F(1.0f), turn), (to_float(primitive) + axis.t) / count};
    constexpr float kSmallestRadius = 1e-6f;
    const Vec3<L> around = cross(tangent, away);
    const F turning = F(2.0f * kPi) * max(axis.r * length(around), F(kSmallestRadius));
    out.dp_du = detail::normalize_or<L>(around, frame.t) * turning;
    const Vec3<L> along = tangent * max(select(spline, bend / max(speed, F(1e-30f)), speed), F(kSmallestRadius));
    out.dp_dv = (along + away * axis.dr) * count;
  }
  return out;
}

}  // namespace sheaf
