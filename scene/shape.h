// From a hit to the surface there: position, normals, uv and tangent, for all kinds of shape, generic in the lane.
#pragma once

#include "core/frame.h"
#include "core/warp.h"
#include "scene/scene.h"

namespace sheaf {

/// Reads four words per lane from base + index[lane]. The table must be readable three words beyond its last row.
template <class L> SHEAF_INLINE void gather_row4(const float* base, typename L::Uint index, typename L::Float* out) {
  alignas(kSimdAlignment) std::uint32_t lanes[L::width];
  store(lanes, index);
  const float* rows[L::width];
  for (int lane = 0; lane < L::width; ++lane) rows[lane] = base + lanes[lane];
  load_rows4(rows, out);
}

/// ShapeRow, a lane each.
template <class L> struct ShapeLanes {
  typename L::Uint kind, first_triangle, first_vertex, first_normal, first_uv, material, light;
};

template <class L> SHEAF_INLINE ShapeLanes<L> load_shapes(const SceneView& scene, typename L::Uint shape) {
  typename L::Float w[8];
  const auto* base = reinterpret_cast<const float*>(scene.shapes);
  gather_row4<L>(base, shape * typename L::Uint(8u), w);
  gather_row4<L>(base + 4, shape * typename L::Uint(8u), w + 4);
  return {float_bits(w[0]), float_bits(w[1]), float_bits(w[2]), float_bits(w[3]),
          float_bits(w[4]), float_bits(w[5]), float_bits(w[6])};
}

/// The surface at a hit, in world space.
template <class L> struct SurfacePoint {
  Vec3<L> p;                  ///< on the surface, more exact than origin + t * direction
  Vec3<L> ng;                 ///< geometric normal, unit length
  Vec3<L> ns;                 ///< interpolated normal, unit length
  typename L::Float offset;   ///< how far along +-ng a ray must start so that it cannot hit the same surface
  Vec2<L> uv;                 ///< only with WithUv
  Vec3<L> dp_du;              ///< tangent along u, any length but zero; only with WithUv
};

/// Normalises vectors whose squared length would overflow or underflow.
template <class L> SHEAF_INLINE Vec3<L> normalize_any(Vec3<L> a) {
  const Float<L> m = max_component(abs(a));
  return normalize(a * (Float<L>(1.0f) / max(m, Float<L>(1e-37f))));
}

/// Rounding errors in the position and in Embree's arithmetic are below this many units in the last place of the
/// coordinates involved (tests/test_ray_offset.cpp holds it against shapes from 1e-3 to 1e5 units).
inline constexpr float kOffsetUlps = 8.0f * 5.9604645e-8f;

template <class L, bool WithUv>
SHEAF_INLINE void triangle_uv(const SceneView& scene, const ShapeLanes<L>& shape, const typename L::Uint* vertex,
                              typename L::Float u, typename L::Float v, const Vec3<L>* p, SurfacePoint<L>& out) {
  using F = typename L::Float;
  using U = typename L::Uint;
  const auto has_uv = shape.first_uv != U(kNone);
  F t0[4], t1[4], t2[4];
  const U base = select(has_uv, shape.first_uv, U(0u));
  const auto index = [&](int k) { return select(has_uv, (base + vertex[k]) * U(2u), U(0u)); };
  gather_row4<L>(scene.uvs, index(0), t0);
  gather_row4<L>(scene.uvs, index(1), t1);
  gather_row4<L>(scene.uvs, index(2), t2);
  const F b0 = F(1.0f) - u - v;
  out.uv = {select(has_uv, b0 * t0[0] + u * t1[0] + v * t2[0], u), select(has_uv, b0 * t0[1] + u * t1[1] + v * t2[1], v)};
  const F du1 = t1[0] - t0[0], dv1 = t1[1] - t0[1], du2 = t2[0] - t0[0], dv2 = t2[1] - t0[1];
  const F det = du1 * dv2 - dv1 * du2;
  const auto usable = has_uv & (abs(det) > F(1e-30f));
  const Vec3<L> from_uv = ((p[1] - p[0]) * dv2 - (p[2] - p[0]) * dv1) * (F(1.0f) / select(usable, det, F(1.0f)));
  out.dp_du = select<L>(usable, from_uv, Frame<L>::from_normal(out.ng).s);
}

/// Surface of a triangle mesh at barycentric (u, v).
template <class L, bool WithUv>
SHEAF_INLINE SurfacePoint<L> triangle_point(const SceneView& scene, const ShapeLanes<L>& shape, Mask<L> active,
                                            typename L::Uint primitive, typename L::Float u, typename L::Float v) {
  using F = typename L::Float;
  using U = typename L::Uint;
  const U zero(0u);
  F words[4];
  gather_row4<L>(reinterpret_cast<const float*>(scene.triangles),
                 select(active, (shape.first_triangle + primitive) * U(3u), zero), words);
  U vertex[3];
  Vec3<L> p[3];
  for (int k = 0; k < 3; ++k) {
    vertex[k] = float_bits(words[k]);
    F q[4];
    gather_row4<L>(scene.positions, select(active, (shape.first_vertex + vertex[k]) * U(3u), zero), q);
    p[k] = {q[0], q[1], q[2]};
  }
  const F b0 = F(1.0f) - u - v;
  SurfacePoint<L> out;
  out.p = p[0] * b0 + p[1] * u + p[2] * v;
  out.ng = normalize_any(cross(p[1] - p[0], p[2] - p[0]));
  const Vec3<L> a0 = abs(p[0]), a1 = abs(p[1]), a2 = abs(p[2]);
  const Vec3<L> largest{max(a0.x, max(a1.x, a2.x)), max(a0.y, max(a1.y, a2.y)), max(a0.z, max(a1.z, a2.z))};
  out.offset = F(kOffsetUlps) * (dot(abs(out.ng), largest) + max_component(abs(out.p)));
  out.ns = out.ng;
  const auto smooth = active & (shape.first_normal != U(kNone));
  if (any(smooth)) {
    Vec3<L> n[3];
    for (int k = 0; k < 3; ++k) {
      F q[4];
      gather_row4<L>(scene.normals, select(smooth, (shape.first_normal + vertex[k]) * U(3u), zero), q);
      n[k] = {q[0], q[1], q[2]};
    }
    const Vec3<L> sum = n[0] * b0 + n[1] * u + n[2] * v;
    const F squared = dot(sum, sum);
    const auto usable = smooth & (squared > F(1e-12f));
    out.ns = select<L>(usable, sum * (F(1.0f) / sqrt(select(usable, squared, F(1.0f)))), out.ng);
  }
  if constexpr (WithUv) triangle_uv<L, WithUv>(scene, shape, vertex, u, v, p, out);
  return out;
}

/// A QuadricRow's matrices, a lane each.
template <class L> struct QuadricLanes {
  typename L::Float to_world[12], to_object[12], normal_sign, determinant, uniform_scale, kind;

  SHEAF_INLINE Vec3<L> world_vector(Vec3<L> v) const { return linear(to_world, v); }
  SHEAF_INLINE Vec3<L> world_point(Vec3<L> v) const {
    return linear(to_world, v) + Vec3<L>{to_world[3], to_world[7], to_world[11]};
  }
  SHEAF_INLINE Vec3<L> object_point(Vec3<L> v) const {
    return linear(to_object, v) + Vec3<L>{to_object[3], to_object[7], to_object[11]};
  }
  /// By the inverse transpose; not normalised.
  SHEAF_INLINE Vec3<L> world_normal(Vec3<L> n) const {
    const auto* m = to_object;
    return {m[0] * n.x + m[4] * n.y + m[8] * n.z, m[1] * n.x + m[5] * n.y + m[9] * n.z,
            m[2] * n.x + m[6] * n.y + m[10] * n.z};
  }

 private:
  static SHEAF_INLINE Vec3<L> linear(const typename L::Float* m, Vec3<L> v) {
    return {m[0] * v.x + m[1] * v.y + m[2] * v.z, m[4] * v.x + m[5] * v.y + m[6] * v.z,
            m[8] * v.x + m[9] * v.y + m[10] * v.z};
  }
};

template <class L> SHEAF_INLINE QuadricLanes<L> load_quadrics(const SceneView& scene, typename L::Uint index) {
  QuadricLanes<L> q;
  static_assert(sizeof(QuadricRow) == 28 * sizeof(float));
  const auto* base = reinterpret_cast<const float*>(scene.quadrics);
  const auto row = index * typename L::Uint(28u);
  for (int k = 0; k < 12; k += 4) gather_row4<L>(base + k, row, q.to_world + k);
  for (int k = 0; k < 12; k += 4) gather_row4<L>(base + 12 + k, row, q.to_object + k);
  typename L::Float rest[4];
  gather_row4<L>(base + 24, row, rest);
  q.normal_sign = rest[0];
  q.determinant = rest[1];
  q.uniform_scale = rest[2];
  q.kind = rest[3];
  return q;
}

/// The quadric at the canonical shape's point `x`.
template <class L, bool WithUv>
SHEAF_INLINE SurfacePoint<L> quadric_surface(const QuadricLanes<L>& q, typename L::Uint kind, Vec3<L> x) {
  using F = typename L::Float;
  using U = typename L::Uint;
  const auto disk = kind == U(static_cast<std::uint32_t>(ShapeKind::kDisk));
  const auto sphere = kind == U(static_cast<std::uint32_t>(ShapeKind::kSphere));
  const Vec3<L> n = {select(disk, F(0.0f), x.x), select(disk, F(0.0f), x.y), select(disk, F(1.0f), select(sphere, x.z, F(0.0f)))};
  SurfacePoint<L> out;
  out.p = q.world_point(x);
  out.ng = out.ns = normalize_any(q.world_normal(n)) * q.normal_sign;
  F extent(0.0f);
  for (int row = 0; row < 12; row += 4)
    extent = max(extent, abs(q.to_world[row]) + abs(q.to_world[row + 1]) + abs(q.to_world[row + 2]) + abs(q.to_world[row + 3]));
  out.offset = F(kOffsetUlps) * extent;
  if constexpr (WithUv) {
    const F turn = atan2(x.y, x.x) * F(0.5f * kInvPi);
    const F angle = select(turn < F(0.0f), turn + F(1.0f), turn);
    const F radius = sqrt(x.x * x.x + x.y * x.y);
    const F polar = acos(clamp(x.z, F(-1.0f), F(1.0f))) * F(kInvPi);
    out.uv = {select(disk, radius, angle), select(disk, angle, select(sphere, polar, x.z))};
    const auto on_axis = radius <= F(1e-20f);
    const F scale = F(1.0f) / select(on_axis, F(1.0f), radius);
    const F cos_angle = select(on_axis, F(1.0f), x.x * scale), sin_angle = select(on_axis, F(0.0f), x.y * scale);
    out.dp_du = q.world_vector({select(disk, cos_angle, -sin_angle), select(disk, sin_angle, cos_angle), F(0.0f)});
  }
  return out;
}

/// Surface of a quadric nearest to the world-space point `hit`.
template <class L, bool WithUv>
SHEAF_INLINE SurfacePoint<L> quadric_point(const SceneView& scene, const ShapeLanes<L>& shape, Mask<L> active, Vec3<L> hit) {
  using F = typename L::Float;
  using U = typename L::Uint;
  const QuadricLanes<L> q = load_quadrics<L>(scene, select(active, shape.first_triangle, U(0u)));
  Vec3<L> x = q.object_point(hit);
  const auto disk = shape.kind == U(static_cast<std::uint32_t>(ShapeKind::kDisk));
  const auto sphere = shape.kind == U(static_cast<std::uint32_t>(ShapeKind::kSphere));
  const F squared = x.x * x.x + x.y * x.y + select(sphere, x.z * x.z, F(0.0f));
  const F scale = select(disk, F(1.0f), F(1.0f) / sqrt(max(squared, F(1e-30f))));
  x = {x.x * scale, x.y * scale, select(disk, F(0.0f), select(sphere, x.z * scale, x.z))};
  return quadric_surface<L, WithUv>(q, shape.kind, x);
}

/// The surface at hits: `hit_point` is origin + t * direction, (u, v) Embree's barycentric coordinates.
template <class L, bool WithUv = false>
SHEAF_INLINE SurfacePoint<L> surface_point(const SceneView& scene, const ShapeLanes<L>& shape, typename L::Uint primitive,
                                           typename L::Float u, typename L::Float v, Vec3<L> hit_point) {
  const auto mesh = shape.kind == typename L::Uint(static_cast<std::uint32_t>(ShapeKind::kMesh));
  if (all(mesh)) return triangle_point<L, WithUv>(scene, shape, mesh, primitive, u, v);
  SurfacePoint<L> out = quadric_point<L, WithUv>(scene, shape, !mesh, hit_point);
  if (!any(mesh)) return out;
  const SurfacePoint<L> triangle = triangle_point<L, WithUv>(scene, shape, mesh, primitive, u, v);
  out.p = select<L>(mesh, triangle.p, out.p);
  out.ng = select<L>(mesh, triangle.ng, out.ng);
  out.ns = select<L>(mesh, triangle.ns, out.ns);
  out.offset = select(mesh, triangle.offset, out.offset);
  if constexpr (WithUv) {
    out.uv = {select(mesh, triangle.uv.x, out.uv.x), select(mesh, triangle.uv.y, out.uv.y)};
    out.dp_du = select<L>(mesh, triangle.dp_du, out.dp_du);
  }
  return out;
}

/// Where a ray towards `direction` starts so that it leaves the surface.
template <class L> SHEAF_INLINE Vec3<L> offset_origin(Vec3<L> p, Vec3<L> ng, typename L::Float offset, Vec3<L> direction) {
  return p + ng * copysign(offset, dot(ng, direction));
}

}  // namespace sheaf
