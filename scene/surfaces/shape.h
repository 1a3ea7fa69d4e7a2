// Surface interaction at hits: position, normals, uv and tangents of all kinds of shapes, generic in the lane policy.
#pragma once

#include "core/sampling/warp.h"
#include "scene/surfaces/curve_surface.h"
#include "scene/surfaces/sdf_surface.h"
#include "scene/tables/instance.h"
#include "scene/tables/motion_sample.h"

namespace sheaf {

template <class L, bool kWithUv>
SHEAF_INLINE void triangle_uv(const ShapeRecord<L>& shape, const Vec2<L>* t, typename L::Float u, typename L::Float v,
                              const Vec3<L>* p, SurfacePoint<L>& out) {
  using F = typename L::Float;
  using U = typename L::Uint;
  const auto has_uv = (shape.flags & U(kHasUvs)) != U(0u);
  const F b0 = F(1.0f) - u - v;
  out.uv = {select(has_uv, b0 * t[0].x + u * t[1].x + v * t[2].x, u),
            select(has_uv, b0 * t[0].y + u * t[1].y + v * t[2].y, v)};
  const F du1 = t[1].x - t[0].x, dv1 = t[1].y - t[0].y, du2 = t[2].x - t[0].x, dv2 = t[2].y - t[0].y;
  const F det = du1 * dv2 - dv1 * du2;
  const auto usable = has_uv & (abs(det) > F(1e-30f));
  const F inverse = F(1.0f) / select(usable, det, F(1.0f));
  const Vec3<L> edge1 = p[1] - p[0], edge2 = p[2] - p[0];
  const auto frame = Frame<L>::from_normal(out.ng);
  out.dp_du = select<L>(usable, (edge1 * dv2 - edge2 * dv1) * inverse, frame.s);
  out.dp_dv = select<L>(usable, (edge2 * du1 - edge1 * du2) * inverse, frame.t);
  out.squared_uv_lengths = {select(usable, dot(out.dp_du, out.dp_du), F(kInfinity)),
                            select(usable, dot(out.dp_dv, out.dp_dv), F(kInfinity))};
}

/// Moves the vertices of triangles at the first step of their meshes, which may deform, to where they are at times in
/// [0, 1]. `corners`: relative to the shape's first vertex. Adds to `extent` the changes over the shutter if the
/// vertices always moved as now, which errors of the time are proportional to.
template <class L>
[[gnu::noinline]] void deform_triangles(const SceneView& scene, const ShapeRecord<L>& shape, Mask<L> active,
                                        const Uint<L> (&corners)[3], Float<L> time, Vec3<L> (&p)[3], Vec3<L> (&n)[3],
                                        Vec3<L>& extent) {
  using U = Uint<L>;
  const DeformationSegment<L> segment = deformation_segment<L>(scene.motion, shape.flags, active, time);
  if (!any(segment.deforms)) return;
  const U first = shape.first_vertex + segment.step * segment.vertex_count;
  for (std::size_t k = 0; k < 3; ++k) {
    const U row = select(segment.deforms, first + corners[k], U(0u));
    const auto a = gather_rows<L>(scene.geometry.vertices, row);
    const auto b = gather_rows<L>(scene.geometry.vertices, select(segment.deforms, row + segment.vertex_count, U(0u)));
    const Vec3<L> change = b.position - a.position, normal_change = b.normal - a.normal;
    p[k] = select<L>(segment.deforms, a.position + change * segment.t, p[k]);
    n[k] = select<L>(segment.deforms, a.normal + normal_change * segment.t, n[k]);
    extent = select<L>(segment.deforms, extent + abs(change) * segment.segments, extent);
  }
}

/// Replaces the derivatives of the position by the tangent and the bitangent of triangles that have tangents.
/// `corners`: relative to the shape's first vertex.
template <class L>
[[gnu::noinline]] void apply_tangents(const SceneView& scene, const ShapeRecord<L>& shape, Mask<L> active,
                                      const Uint<L> (&corners)[3], Float<L> u, Float<L> v, Float<L> time,
                                      SurfacePoint<L>& out) {
  using F = Float<L>;
  using U = Uint<L>;
  TangentRecord<L> t[3];
  for (std::size_t k = 0; k < 3; ++k)
    t[k] = gather_rows<L>(scene.geometry.tangents, select(active, shape.first_vertex + corners[k], U(0u)));
  if (scene.motion.deformations != nullptr) {
    const DeformationSegment<L> segment = deformation_segment<L>(scene.motion, shape.flags, active, time);
    const U first = shape.first_vertex + segment.step * segment.vertex_count;
    for (std::size_t k = 0; k < 3; ++k) {
      const U row = select(segment.deforms, first + corners[k], U(0u));
      const U next = select(segment.deforms, row + segment.vertex_count, U(0u));
      const Vec3<L> a = gather_rows<L>(scene.geometry.tangents, row).direction;
      const Vec3<L> b = gather_rows<L>(scene.geometry.tangents, next).direction;
      t[k].direction = select<L>(segment.deforms, a + (b - a) * segment.t, t[k].direction);
    }
  }
  const Vec3<L> sum = t[0].direction * (F(1.0f) - u - v) + t[1].direction * u + t[2].direction * v;
  const Mask<L> usable = active & (dot(sum, sum) > F(1e-12f));
  out.dp_du = select<L>(usable, sum, out.dp_du);
  out.dp_dv = select<L>(usable, cross(out.ns, sum) * t[0].handedness, out.dp_dv);
}

/// Surface point of a triangle mesh at barycentric coordinates (u, v), at times in [0, 1].
template <class L, bool kWithUv>
SHEAF_INLINE SurfacePoint<L> triangle_point(const SceneView& scene, const ShapeRecord<L>& shape, Mask<L> active,
                                            typename L::Uint primitive, typename L::Float u, typename L::Float v,
                                            typename L::Float time) {
  using F = typename L::Float;
  using U = typename L::Uint;
  const U zero(0u);
  const auto corners =
      gather_triple<L>(scene.geometry.triangles, select(active, shape.first_triangle + primitive, zero));
  Vec3<L> p[3], n[3];
  Vec2<L> t[3];
  for (std::size_t k = 0; k < 3; ++k) {
    const auto vertex = gather_rows<L>(scene.geometry.vertices, select(active, shape.first_vertex + corners[k], zero));
    p[k] = vertex.position;
    n[k] = vertex.normal;
    t[k] = vertex.uv;
  }
  Vec3<L> moved{F(0.0f), F(0.0f), F(0.0f)};
  if (scene.motion.deformations != nullptr)
    deform_triangles<L>(scene, shape, active, {corners[0], corners[1], corners[2]}, time, p, n, moved);
  const F b0 = F(1.0f) - u - v;
  SurfacePoint<L> out;
  out.p = p[0] * b0 + p[1] * u + p[2] * v;
  out.ng = normalize_any(cross(p[1] - p[0], p[2] - p[0]));
  const Vec3<L> a0 = abs(p[0]), a1 = abs(p[1]), a2 = abs(p[2]);
  const Vec3<L> largest{max(a0.x, max(a1.x, a2.x)), max(a0.y, max(a1.y, a2.y)), max(a0.z, max(a1.z, a2.z))};
  out.offset = F(kOffsetUlps) * (dot(abs(out.ng), largest) + max_component(abs(out.p)));
  if (scene.motion.deformations != nullptr) out.offset = out.offset + F(kOffsetUlps) * (dot(abs(out.ng), moved));
  out.ns = out.ng;
  const auto smooth = active & ((shape.flags & U(kHasNormals)) != U(0u));
  if (any(smooth)) {
    const Vec3<L> sum = n[0] * b0 + n[1] * u + n[2] * v;
    const F squared = dot(sum, sum);
    const auto usable = smooth & (squared > F(1e-12f));
    out.ns = select<L>(usable, sum * (F(1.0f) / sqrt(select(usable, squared, F(1.0f)))), out.ng);
  }
  if constexpr (kWithUv) {
    triangle_uv<L, kWithUv>(shape, t, u, v, p, out);
    if (scene.geometry.tangents != nullptr)
      apply_tangents<L>(scene, shape, active, {corners[0], corners[1], corners[2]}, u, v, time, out);
  }
  return out;
}

/// Surface point of a quadric at the point `x` of the canonical shape.
template <class L, bool kWithUv>
SHEAF_INLINE SurfacePoint<L> quadric_surface(const QuadricRecord<L>& q, typename L::Uint kind, Vec3<L> x) {
  using F = typename L::Float;
  using U = typename L::Uint;
  const auto disk = kind == U(static_cast<std::uint32_t>(ShapeKind::kDisk));
  const auto sphere = kind == U(static_cast<std::uint32_t>(ShapeKind::kSphere));
  // Compute position, normal and offset
  const Vec3<L> n = {select(disk, F(0.0f), x.x), select(disk, F(0.0f), x.y),
                     select(disk, F(1.0f), select(sphere, x.z, F(0.0f)))};
  SurfacePoint<L> out;
  out.p = q.world_point(x);
  out.ng = out.ns = normalize_any(q.world_normal(n)) * q.normal_sign;
  F extent(0.0f);
  for (int row = 0; row < 12; row += 4)
    extent = max(extent,
                 abs(q.to_world[row]) + abs(q.to_world[row + 1]) + abs(q.to_world[row + 2]) + abs(q.to_world[row + 3]));
  out.offset = F(kOffsetUlps) * extent;
  if constexpr (kWithUv) {
    // Compute the texture coordinates
    const F azimuth = atan2(x.y, x.x) * F(0.5f * kInvPi);
    const F angle = select(azimuth < F(0.0f), azimuth + F(1.0f), azimuth);
    const F radius = sqrt(x.x * x.x + x.y * x.y);
    const F polar = acos(clamp(x.z, F(-1.0f), F(1.0f))) * F(kInvPi);
    out.uv = {select(disk, radius, angle), select(disk, angle, select(sphere, polar, x.z))};
    // Compute their derivatives
    const auto on_axis = radius <= F(1e-20f);
    const F scale = F(1.0f) / select(on_axis, F(1.0f), radius);
    const F cos_angle = select(on_axis, F(1.0f), x.x * scale), sin_angle = select(on_axis, F(0.0f), x.y * scale);
    constexpr float kSmallestRadius = 1e-6f;
    const F turning = F(2.0f * kPi) * max(radius, F(kSmallestRadius));
    const Vec3<L> around = q.world_vector({-sin_angle * turning, cos_angle * turning, F(0.0f)});
    const Vec3<L> outward = q.world_vector({cos_angle, sin_angle, F(0.0f)});
    const F pi(kPi);
    const Vec3<L> along =
        q.world_vector({select(sphere, cos_angle * x.z * pi, F(0.0f)), select(sphere, sin_angle * x.z * pi, F(0.0f)),
                        select(sphere, -radius * pi, F(1.0f))});
    out.dp_du = select<L>(disk, outward, around);
    out.dp_dv = select<L>(disk, around, along);
    out.squared_uv_lengths = {dot(out.dp_du, out.dp_du), dot(out.dp_dv, out.dp_dv)};
  }
  return out;
}

/// Surface point of a quadric nearest to the world-space point `hit`.
template <class L, bool kWithUv>
SHEAF_INLINE SurfacePoint<L> quadric_point(const SceneView& scene, const ShapeRecord<L>& shape, Mask<L> active,
                                           Vec3<L> hit) {
  using F = typename L::Float;
  using U = typename L::Uint;
  const QuadricRecord<L> q = gather_rows<L>(scene.geometry.quadrics, select(active, shape.first_triangle, U(0u)));
  Vec3<L> x = q.object_point(hit);
  const auto disk = shape.kind == U(static_cast<std::uint32_t>(ShapeKind::kDisk));
  const auto sphere = shape.kind == U(static_cast<std::uint32_t>(ShapeKind::kSphere));
  const F squared = x.x * x.x + x.y * x.y + select(sphere, x.z * x.z, F(0.0f));
  const F scale = select(disk, F(1.0f), F(1.0f) / sqrt(max(squared, F(1e-30f))));
  x = {x.x * scale, x.y * scale, select(disk, F(0.0f), select(sphere, x.z * scale, x.z))};
  return quadric_surface<L, kWithUv>(q, shape.kind, x);
}

/// Transforms surface points from a group's space to world space, only in lanes of `instanced`.
template <class L, bool kWithUv>
SHEAF_INLINE void place_instance(const InstancePlacement<L>& placed, Mask<L> instanced, SurfacePoint<L>& y) {
  using F = typename L::Float;
  const Vec3<L> normal = placed.normal(y.ng);
  const F largest = max(max_component(abs(normal)), F(1e-37f));
  const Vec3<L> scaled = normal * (F(1.0f) / largest);
  const F scaled_length = sqrt(dot(scaled, scaled));
  // Embree transforms rays to the group's space. Errors along the normal there are those of the surface point and those
  // of the transform. The latter are bounded by the absolute terms of the inverse times those of the point.
  const Vec3<L> bound = placed.absolute_point(y.p);
  const F error =
      y.offset * abs(placed.determinant) + F(kOffsetUlps) * dot(abs(y.ng), placed.absolute_cofactors(bound));
  y.offset = select(instanced, error / (largest * scaled_length), y.offset);
  y.p = select<L>(instanced, placed.point(y.p), y.p);
  y.ng = select<L>(instanced, scaled * (F(1.0f) / scaled_length), y.ng);
  y.ns = select<L>(instanced, normalize_any(placed.normal(y.ns)), y.ns);
  if constexpr (kWithUv) {
    const auto place = [&](Vec3<L>& derivative, F& squared_length) SHEAF_LAMBDA_INLINE {
      const Vec3<L> vector = placed.vector(derivative);
      const F scale = dot(vector, vector) / dot(derivative, derivative);
      squared_length = select(instanced, squared_length * scale, squared_length);
      derivative = select<L>(instanced, vector, derivative);
    };
    place(y.dp_du, y.squared_uv_lengths.x);
    place(y.dp_dv, y.squared_uv_lengths.y);
  }
}

/// Surface points for a mix of kinds of shapes, in the space in which they were compiled: world space or a group's
/// space.
template <class L, bool kWithUv>
[[gnu::noinline]] SurfacePoint<L> mixed_point(const SceneView& scene, const ShapeRecord<L>& shape, Uint<L> primitive,
                                              Float<L> u, Float<L> v, Vec3<L> hit_point, Float<L> time) {
  const auto is = [&](ShapeKind kind)
                      SHEAF_LAMBDA_INLINE { return shape.kind == typename L::Uint(static_cast<std::uint32_t>(kind)); };
  const auto mesh = is(ShapeKind::kMesh);
  const Mask<L> curve = is(ShapeKind::kLinearCurves) | is(ShapeKind::kBsplineCurves), field = is(ShapeKind::kSdfGrid);
  const auto quadric = !(mesh | curve | field);
  SurfacePoint<L> out{};
  if (any(quadric)) out = quadric_point<L, kWithUv>(scene, shape, quadric, hit_point);
  if (any(curve | field)) {
    if (any(curve))
      out = select<L, kWithUv>(curve, curve_point<L, kWithUv>(scene, shape, curve, primitive, u, hit_point, time), out);
    if (any(field))
      out = select<L, kWithUv>(field, sdf_point<L, kWithUv>(scene, shape, field, primitive, hit_point), out);
  }
  if (!any(mesh)) return out;
  return select<L, kWithUv>(mesh, triangle_point<L, kWithUv>(scene, shape, mesh, primitive, u, v, time), out);
}

/// Surface points at hits. `hit_point` is origin + t * direction, (u, v) are Embree's barycentric coordinates, and
/// `instance` is the instance that was hit, or kNone for shapes outside of groups. `time`: of the ray, in [0, 1].
template <class L, bool kWithUv = false>
SHEAF_INLINE SurfacePoint<L> surface_point(const SceneView& scene, const ShapeRecord<L>& shape, Uint<L> primitive,
                                           Float<L> u, Float<L> v, Vec3<L> hit_point, Uint<L> instance, Float<L> time) {
  using U = typename L::Uint;
  const auto instanced = instance != U(kNone);
  const bool any_placed = scene.geometry.instances != nullptr && any(instanced);
  const auto placement = [&](Vec3<L> p) SHEAF_LAMBDA_INLINE {
    const auto row = gather_rows<L>(scene.geometry.instances, select(instanced, instance, U(0u)));
    return placement_at<L>(scene.motion, row, instance, instanced, time, p);
  };
  const auto mesh = shape.kind == U(static_cast<std::uint32_t>(ShapeKind::kMesh));
  SurfacePoint<L> out;
  if (all(mesh)) {
    out = triangle_point<L, kWithUv>(scene, shape, mesh, primitive, u, v, time);
  } else {
    if (any_placed) hit_point = select<L>(instanced, placement(hit_point).placed.object_point(hit_point), hit_point);
    out = mixed_point<L, kWithUv>(scene, shape, primitive, u, v, hit_point, time);
  }
  if (any_placed) {
    const InstanceAt<L> at = placement(out.p);
    place_instance<L, kWithUv>(at.placed, instanced, out);
    if (scene.motion.instances != nullptr)
      out.offset = out.offset + select(instanced, at.error * Float<L>(kOffsetUlps), Float<L>(0.0f));
  }
  return out;
}

/// Origin of a ray towards `direction`, offset to leave the surface.
template <class L>
SHEAF_INLINE Vec3<L> offset_origin(Vec3<L> p, Vec3<L> ng, typename L::Float offset, Vec3<L> direction) {
  return p + ng * copysign(offset, dot(ng, direction));
}

}  // namespace sheaf
