// Light sampling: a point on a light, the radiance it sends to a reference point, and with which density it was chosen;
// and the same density for a point that BSDF sampling found.
#pragma once

#include "core/sampler.h"
#include "kernels/light_select.h"
#include "scene/shape.h"

namespace sheaf {

/// LightRow, a lane each.
template <class L> struct LightLanes {
  typename L::Uint kind, shape, first_triangle, triangle_count;
  Spectrum<L> radiance;
  Vec3<L> position;
  typename L::Float area, radius, pdf_select;

  SHEAF_INLINE typename L::Mask is(LightKind k) const { return kind == typename L::Uint(static_cast<std::uint32_t>(k)); }
};

template <class L> SHEAF_INLINE LightLanes<L> load_lights(const SceneView& scene, typename L::Uint light) {
  typename L::Float w[16];
  const auto* base = reinterpret_cast<const float*>(scene.lights);
  for (int k = 0; k < 16; k += 4) gather_row4<L>(base + k, light * typename L::Uint(16u), w + k);
  return {float_bits(w[0]), float_bits(w[1]),       float_bits(w[2]),    float_bits(w[3]), {w[4], w[5], w[6], w[7]},
          {w[8], w[9], w[10]}, w[11], w[12], w[13]};
}

/// Light that arrives at a reference point from a sampled direction.
template <class L> struct LightSample {
  Vec3<L> direction;            ///< from the reference point, unit length
  Vec3<L> target;               ///< where the shadow ray ends: on the light, moved off its surface
  Spectrum<L> radiance;         ///< incident radiance; point lights: intensity over squared distance
  typename L::Float pdf_solid_angle;  ///< selection included; for point lights the selection probability alone
  typename L::Mask delta;       ///< BSDF sampling cannot find this light
  typename L::Mask valid;       ///< false: nothing arrives
};

/// 1 - cos of the half angle under which a sphere is seen, stable for small ones; 0 from inside.
template <class F> SHEAF_INLINE F sphere_one_minus_cos(F radius, F distance_squared) {
  const F sin2 = min(radius * radius / max(distance_squared, F(1e-37f)), F(1.0f));
  return select(sin2 < F(1.0f), sin2 / (F(1.0f) + safe_sqrt(F(1.0f) - sin2)), F(0.0f));
}

namespace light_detail {

/// Turns a point on an area light into a sample: density from area to solid angle, and one-sidedness.
template <class L>
SHEAF_INLINE LightSample<L> from_area(Vec3<L> from, const SurfacePoint<L>& y, const LightLanes<L>& light, Float<L> pdf_area) {
  using F = Float<L>;
  LightSample<L> s;
  const Vec3<L> d = y.p - from;
  const F squared = dot(d, d);
  s.direction = d * (F(1.0f) / sqrt(max(squared, F(1e-37f))));
  const F cos_light = -dot(s.direction, y.ng);
  s.valid = (cos_light > F(1e-6f)) & (squared > F(0.0f));
  s.pdf_solid_angle = light.pdf_select * pdf_area * squared / select(s.valid, cos_light, F(1.0f));
  s.target = y.p + y.ng * y.offset;
  s.radiance = light.radiance;
  s.delta = Mask<L>(false);
  return s;
}

template <class L>
SHEAF_INLINE LightSample<L> sample_mesh(const SceneView& scene, Vec3<L> from, const LightLanes<L>& light, Mask<L> active,
                                        const Random4<L>& u) {
  using F = Float<L>;
  using U = Uint<L>;
  const U first = select(active, light.first_triangle, U(0u));
  const auto triangle =
      sample_alias<L>(scene.triangle_alias, first, select(active, light.triangle_count, U(1u)), u.w);
  F w[16];
  const auto* base = reinterpret_cast<const float*>(scene.light_triangles);
  for (int k = 0; k < 16; k += 4) gather_row4<L>(base + k, (first + triangle.index) * U(16u), w + k);
  const Vec2<L> b = square_to_triangle<L>(u.y, u.z);
  SurfacePoint<L> y;
  y.p = Vec3<L>{w[0], w[1], w[2]} + Vec3<L>{w[4], w[5], w[6]} * b.x + Vec3<L>{w[8], w[9], w[10]} * b.y;
  y.ng = {w[12], w[13], w[14]};
  y.offset = w[3];
  return from_area<L>(from, y, light, F(1.0f) / light.area);
}

template <class L>
SHEAF_INLINE LightSample<L> sample_quadric(const SceneView& scene, Vec3<L> from, const LightLanes<L>& light, Mask<L> active,
                                           const Random4<L>& u) {
  using F = Float<L>;
  using U = Uint<L>;
  const ShapeLanes<L> shape = load_shapes<L>(scene, select(active, light.shape, U(0u)));
  const auto q = load_quadrics<L>(scene, select(active, shape.first_triangle, U(0u)));
  const Vec3<L> on_sphere = square_to_sphere<L>(u.y, u.z);
  const Vec2<L> on_disk = square_to_disk<L>(u.y, u.z);
  const auto angle = sincos_2pi<L>(u.y);
  const auto disk = shape.kind == U(static_cast<std::uint32_t>(ShapeKind::kDisk));
  const auto cylinder = shape.kind == U(static_cast<std::uint32_t>(ShapeKind::kCylinder));
  Vec3<L> x = select<L>(disk, {on_disk.x, on_disk.y, F(0.0f)}, on_sphere);
  x = select<L>(cylinder, {angle.cos, angle.sin, u.z}, x);
  const auto y = quadric_surface<L, false>(q, shape.kind, x);
  // The area element grows by |det| |M^-T n|.
  const Vec3<L> n = {select(disk, F(0.0f), x.x), select(disk, F(0.0f), x.y),
                     select(disk, F(1.0f), select(cylinder, F(0.0f), x.z))};
  const F pdf_area = F(1.0f) / max(light.area * q.determinant * length(q.world_normal(n)), F(1e-37f));
  return from_area<L>(from, y, light, pdf_area);
}

/// Directions inside the cone under which the sphere is seen (Pharr et al. 2023, section 6.2.4).
template <class L>
SHEAF_INLINE LightSample<L> sample_sphere(Vec3<L> from, const LightLanes<L>& light, const Random4<L>& u) {
  using F = Float<L>;
  const Vec3<L> to_center = light.position - from;
  const F squared = dot(to_center, to_center);
  const F one_minus_cos_max = sphere_one_minus_cos(light.radius, squared);
  LightSample<L> s;
  s.valid = one_minus_cos_max > F(0.0f);
  const F distance = sqrt(max(squared, F(1e-37f)));
  const auto frame = Frame<L>::from_normal(to_center * (F(1.0f) / distance));
  const Vec3<L> local = square_to_cone<L>(u.y, u.z, one_minus_cos_max);
  s.direction = frame.to_world(local);
  // Normal of the sphere where the direction meets it first.
  const F sin2 = max(F(0.0f), F(1.0f) - local.z * local.z);
  const F along = distance * local.z - safe_sqrt(light.radius * light.radius - squared * sin2);
  const Vec3<L> normal = (s.direction * along - to_center) * (F(1.0f) / light.radius);
  const F extent = max_component(abs(light.position)) + light.radius;
  const F n_length = sqrt(max(dot(normal, normal), F(1e-12f)));
  s.target = light.position + normal * ((light.radius + F(2.0f * kOffsetUlps) * extent) / n_length);
  s.pdf_solid_angle = light.pdf_select * F(0.5f * kInvPi) / select(s.valid, one_minus_cos_max, F(1.0f));
  s.radiance = light.radiance;
  s.delta = Mask<L>(false);
  return s;
}

template <class L> SHEAF_INLINE LightSample<L> sample_point(Vec3<L> from, const LightLanes<L>& light) {
  using F = Float<L>;
  const Vec3<L> d = light.position - from;
  const F squared = dot(d, d);
  LightSample<L> s;
  s.valid = squared > F(1e-37f);
  const F inverse = F(1.0f) / select(s.valid, squared, F(1.0f));
  s.direction = d * sqrt(inverse);
  s.target = light.position;
  s.radiance = light.radiance * inverse;
  s.pdf_solid_angle = light.pdf_select;
  s.delta = Mask<L>(true);
  return s;
}

template <class L>
SHEAF_INLINE LightSample<L> sample_constant(const SceneView& scene, Vec3<L> from, const LightLanes<L>& light, const Random4<L>& u) {
  using F = Float<L>;
  LightSample<L> s;
  s.direction = square_to_sphere<L>(u.y, u.z);
  s.target = from + s.direction * F(2.1f * scene.radius);
  s.radiance = light.radiance;
  s.pdf_solid_angle = light.pdf_select * F(kUniformSpherePdf);
  s.delta = Mask<L>(false);
  s.valid = Mask<L>(true);
  return s;
}

template <class L> SHEAF_INLINE void merge(Mask<L> m, const LightSample<L>& a, LightSample<L>& into) {
  into.direction = select<L>(m, a.direction, into.direction);
  into.target = select<L>(m, a.target, into.target);
  into.radiance = select<L>(m, a.radiance, into.radiance);
  into.pdf_solid_angle = select(m, a.pdf_solid_angle, into.pdf_solid_angle);
  into.delta = select(m, a.delta, into.delta);
  into.valid = select(m, a.valid, into.valid);
}

}  // namespace light_detail

/// A direction from `from` towards the light that was chosen. The scene must have lights.
template <class L>
SHEAF_INLINE LightSample<L> sample_light(const SceneView& scene, Vec3<L> from, const LightChoice<L>& choice,
                                         const Random4<L>& u) {
  using namespace light_detail;
  LightLanes<L> light = load_lights<L>(scene, choice.light);
  light.pdf_select = choice.probability;
  const auto mesh = light.is(LightKind::kMesh), sphere = light.is(LightKind::kSphere);
  const auto quadric = light.is(LightKind::kQuadric), point = light.is(LightKind::kPoint);
  const auto constant = light.is(LightKind::kConstant);
  LightSample<L> s{};
  if (all(mesh)) return sample_mesh<L>(scene, from, light, mesh, u);
  if (any(mesh)) merge<L>(mesh, sample_mesh<L>(scene, from, light, mesh, u), s);
  if (any(sphere)) merge<L>(sphere, sample_sphere<L>(from, light, u), s);
  if (any(quadric)) merge<L>(quadric, sample_quadric<L>(scene, from, light, quadric, u), s);
  if (any(point)) merge<L>(point, sample_point<L>(from, light), s);
  if (any(constant)) merge<L>(constant, sample_constant<L>(scene, from, light, u), s);
  return s;
}

/// The density, LightLanes::pdf_select included, with which sample_light from `from` would have found the point at
/// distance `t` in `direction` on an area light with geometric normal `ng` there.
template <class L>
SHEAF_INLINE Float<L> light_pdf_solid_angle(const SceneView& scene, const LightLanes<L>& light, Mask<L> active,
                                            Vec3<L> from, Vec3<L> direction, Float<L> t, Vec3<L> ng) {
  using F = Float<L>;
  using U = Uint<L>;
  const F cos_light = abs(dot(direction, ng));
  F pdf_area = F(1.0f) / light.area;
  const auto sphere = active & light.is(LightKind::kSphere), quadric = active & light.is(LightKind::kQuadric);
  if (any(quadric)) {
    const ShapeLanes<L> shape = load_shapes<L>(scene, select(quadric, light.shape, U(0u)));
    const auto q = load_quadrics<L>(scene, select(quadric, shape.first_triangle, U(0u)));
    // |M^-T n| for the canonical unit normal n is 1 / |M^T ng|.
    const auto* m = q.to_world;
    const Vec3<L> back{m[0] * ng.x + m[4] * ng.y + m[8] * ng.z, m[1] * ng.x + m[5] * ng.y + m[9] * ng.z,
                       m[2] * ng.x + m[6] * ng.y + m[10] * ng.z};
    pdf_area = select(quadric, length(back) / max(light.area * q.determinant, F(1e-37f)), pdf_area);
  }
  F pdf = pdf_area * t * t / max(cos_light, F(1e-6f));
  if (any(sphere)) {
    const Vec3<L> to_center = light.position - from;
    const F one_minus_cos_max = sphere_one_minus_cos(light.radius, dot(to_center, to_center));
    const auto outside = one_minus_cos_max > F(0.0f);
    pdf = select(sphere, select(outside, F(0.5f * kInvPi) / select(outside, one_minus_cos_max, F(1.0f)), F(0.0f)), pdf);
  }
  return light.pdf_select * pdf;
}

}  // namespace sheaf
