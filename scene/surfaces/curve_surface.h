// Surface interaction of round curves, generic in the lane policy.
#pragma once

#include "scene/surfaces/surface.h"
#include "scene/tables/motion_sample.h"

namespace sheaf {

namespace detail {

/// The axis of a tube at a parameter of one segment.
template <class L> struct CurveAxis {
  Vec3<L> p, dp;                ///< position and its derivative by the parameter
  typename L::Float r, dr;      ///< radius and its derivative by the parameter
  Vec3<L> ddp;                  ///< second derivative of the position; 0 for lines
  typename L::Float t, extent;  ///< the parameter; the largest coordinate of the segment
};

/// Normalizes `a`; `default_value` if its length is zero.
template <class L> SHEAF_INLINE Vec3<L> normalize_or(Vec3<L> a, Vec3<L> default_value) {
  using F = typename L::Float;
  const F m = max_component(abs(a));
  const auto usable = m > F(1e-30f);
  return select<L>(usable, normalize(select<L>(usable, a * (F(1.0f) / max(m, F(1e-30f))), default_value)),
                   default_value);
}

/// Axis of a line segment at t.
template <class L> SHEAF_INLINE CurveAxis<L> linear_axis_at(const CurvePointRecord<L>* q, typename L::Float t) {
  using F = typename L::Float;
  CurveAxis<L> out;
  out.dp = q[1].position - q[0].position;
  out.dr = q[1].radius - q[0].radius;
  out.t = t;
  out.p = q[0].position + out.dp * out.t;
  out.r = q[0].radius + out.dr * out.t;
  out.ddp = {F(0.0f), F(0.0f), F(0.0f)};
  return out;
}

/// Axis of a line segment at the t whose sphere touches the cone at `hit`: (hit - p(t)) . dp = -r(t) dr.
template <class L> SHEAF_INLINE CurveAxis<L> linear_axis(const CurvePointRecord<L>* q, Vec3<L> hit) {
  using F = typename L::Float;
  const Vec3<L> dp = q[1].position - q[0].position;
  const F dr = q[1].radius - q[0].radius;
  const F slant = dot(dp, dp) - dr * dr;  // not positive: one end's sphere contains the other
  const F along = dot(hit - q[0].position, dp) + q[0].radius * dr;
  const F larger = select(dr > F(0.0f), F(1.0f), F(0.0f));
  const auto cone = slant > F(0.0f);
  return linear_axis_at<L>(q, select(cone, clamp(along / select(cone, slant, F(1.0f)), F(0.0f), F(1.0f)), larger));
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

/// The control points of segments.
template <class L> struct CurveSegment {
  CurvePointRecord<L> points[4];  ///< lines have two
  Mask<L> spline;
  Float<L> extent;  ///< the largest coordinate
};

/// Moves the control points at the first step of their curves, which may deform, to where they are at times in [0, 1].
/// `first`: the first point, relative to the shape. Adds to the extent of those that deform the change over the shutter
/// if the points always moved as now, which errors of the time are proportional to.
template <class L>
[[gnu::noinline]] void deform_segment(const SceneView& scene, const ShapeRecord<L>& shape, Mask<L> active,
                                      Uint<L> first, Float<L> time, CurveSegment<L>& curve) {
  using F = Float<L>;
  using U = Uint<L>;
  const DeformationSegment<L> segment = deformation_segment<L>(scene.motion, shape.flags, active, time);
  if (!any(segment.deforms)) return;
  F extent(0.0f), moved(0.0f);
  for (std::uint32_t k = 0; k < 4; ++k) {
    const auto there = segment.deforms & (k < 2 ? active : curve.spline);
    const U row = select(there, shape.first_vertex + segment.step * segment.vertex_count + first + U(k), U(0u));
    const auto a = gather_rows<L>(scene.geometry.curve_points, row);
    const auto b = gather_rows<L>(scene.geometry.curve_points, select(there, row + segment.vertex_count, U(0u)));
    const Vec3<L> change = b.position - a.position;
    const F widening = b.radius - a.radius;
    CurvePointRecord<L>& q = curve.points[k];
    q.position = select<L>(there, a.position + change * segment.t, q.position);
    q.radius = select(there, a.radius + widening * segment.t, q.radius);
    extent = max(extent, select(there, max_component(abs(q.position)) + q.radius, F(0.0f)));
    moved = max(moved, select(there, (max_component(abs(change)) + abs(widening)) * segment.segments, F(0.0f)));
  }
  curve.extent = select(segment.deforms, extent + moved, curve.extent);
}

/// The segment that was hit, at times in [0, 1].
template <class L>
SHEAF_INLINE CurveSegment<L> curve_segment(const SceneView& scene, const ShapeRecord<L>& shape, Mask<L> active,
                                           typename L::Uint primitive, typename L::Float time) {
  using F = typename L::Float;
  using U = typename L::Uint;
  CurveSegment<L> out;
  out.spline = active & (shape.kind == U(static_cast<std::uint32_t>(ShapeKind::kBsplineCurves)));
  const U zero(0u);
  const U first = gather(scene.geometry.curve_segments, select(active, shape.first_triangle + primitive, zero));
  out.extent = F(0.0f);
  for (std::uint32_t k = 0; k < 4; ++k) {
    const auto there = k < 2 ? active : out.spline;
    CurvePointRecord<L>& q = out.points[k];
    q = gather_rows<L>(scene.geometry.curve_points, select(there, shape.first_vertex + first + U(k), zero));
    out.extent = max(out.extent, select(there, max_component(abs(q.position)) + q.radius, F(0.0f)));
  }
  if (scene.motion.deformations != nullptr) deform_segment<L>(scene, shape, active, first, time, out);
  return out;
}

/// `line`, or for splines the axis at the parameter `u`.
template <class L>
SHEAF_INLINE CurveAxis<L> curve_axis(const CurveSegment<L>& segment, const CurveAxis<L>& line, typename L::Float u) {
  const auto spline = segment.spline;
  CurveAxis<L> out = line;
  if (any(spline)) {
    const CurveAxis<L> smooth = bspline_axis<L>(segment.points, u);
    out = {select<L>(spline, smooth.p, out.p),
           select<L>(spline, smooth.dp, out.dp),
           select(spline, smooth.r, out.r),
           select(spline, smooth.dr, out.dr),
           select<L>(spline, smooth.ddp, out.ddp),
           select(spline, smooth.t, out.t),
           segment.extent};
  }
  out.extent = segment.extent;
  return out;
}

/// The direction from the axis to the point of the surface that is nearest to `hit`.
template <class L>
SHEAF_INLINE Vec3<L> away_from_axis(const CurveAxis<L>& axis, Mask<L> spline, Vec3<L> tangent, Vec3<L> hit,
                                    Vec3<L> default_value) {
  using F = typename L::Float;
  const Vec3<L> from = hit - axis.p;
  return normalize_or<L>(from - tangent * select(spline, dot(from, tangent), F(0.0f)), default_value);
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

/// Surface point of a curve at a hit at times in [0, 1], with `u` along the segment and `hit` near it. Splines sweep a
/// circle perpendicular to the axis; lines sweep a sphere. Not inlined: curves are rare.
template <class L, bool kWithUv>
[[gnu::noinline]] SurfacePoint<L> curve_point(const SceneView& scene, const ShapeRecord<L>& shape, Mask<L> active,
                                              Uint<L> primitive, Float<L> u, Vec3<L> hit, Float<L> time) {
  using F = typename L::Float;
  using U = typename L::Uint;
  const detail::CurveSegment<L> segment = detail::curve_segment<L>(scene, shape, active, primitive, time);
  const detail::CurveAxis<L> axis = detail::curve_axis<L>(segment, detail::linear_axis<L>(segment.points, hit), u);
  const auto spline = shape.kind == U(static_cast<std::uint32_t>(ShapeKind::kBsplineCurves));
  const Vec3<L> z{F(0.0f), F(0.0f), F(1.0f)};
  const Vec3<L> tangent = detail::normalize_or<L>(axis.dp, z);
  const auto frame = Frame<L>::from_normal(tangent);
  const Vec3<L> away = detail::away_from_axis<L>(axis, spline, tangent, hit, frame.s);
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
    const F azimuth = atan2(dot(away, sine), dot(away, cosine)) * F(0.5f * kInvPi);
    out.uv = {select(azimuth < F(0.0f), azimuth + F(1.0f), azimuth), (to_float(primitive) + axis.t) / count};
    constexpr float kSmallestRadius = 1e-6f;
    const Vec3<L> around = cross(tangent, away);
    const F turning = F(2.0f * kPi) * max(axis.r * length(around), F(kSmallestRadius));
    out.dp_du = detail::normalize_or<L>(around, frame.t) * turning;
    const Vec3<L> along = tangent * max(select(spline, bend / max(speed, F(1e-30f)), speed), F(kSmallestRadius));
    out.dp_dv = (along + away * axis.dr) * count;
    out.squared_uv_lengths = {dot(out.dp_du, out.dp_du), dot(out.dp_dv, out.dp_dv)};
  }
  return out;
}

/// Position at time `then` of the point `hit` of a curve at time `now`, both in [0, 1]. It keeps its uv, and on round
/// ends its angle to the axis.
template <class L>
[[gnu::noinline]] Vec3<L> follow_curve(const SceneView& scene, const ShapeRecord<L>& shape, Mask<L> active,
                                       Uint<L> primitive, Float<L> u, Vec3<L> hit, Float<L> now, Float<L> then) {
  using F = Float<L>;
  const Vec3<L> z{F(0.0f), F(0.0f), F(1.0f)};
  const auto before = detail::curve_segment<L>(scene, shape, active, primitive, now),
             after = detail::curve_segment<L>(scene, shape, active, primitive, then);
  const detail::CurveAxis<L> from = detail::curve_axis<L>(before, detail::linear_axis<L>(before.points, hit), u);
  const detail::CurveAxis<L> to = detail::curve_axis<L>(after, detail::linear_axis_at<L>(after.points, from.t), u);
  // Turn the direction from the axis with the axis
  const Vec3<L> tangents[2] = {detail::normalize_or<L>(from.dp, z), detail::normalize_or<L>(to.dp, z)};
  Vec3<L> cosines[2], sines[2];
  for (int i = 0; i < 2; ++i) detail::curve_frame<L>(tangents[i], cosines[i], sines[i]);
  const Vec3<L> away = detail::away_from_axis<L>(from, before.spline, tangents[0], hit, cosines[0]);
  return to.p +
         (cosines[1] * dot(away, cosines[0]) + sines[1] * dot(away, sines[0]) + tangents[1] * dot(away, tangents[0])) *
             to.r;
}

}  // namespace sheaf
