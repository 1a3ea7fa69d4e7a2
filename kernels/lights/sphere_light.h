// Spheres that emit outwards, sampled uniformly in the cone of directions that they subtend (Pharr et al. 2023, section
// 6.2.4).
#pragma once

#include "kernels/lights/quadric_light.h"
#include "scene/lights/sphere_light.h"

namespace sheaf {

/// 1 - cos of the half angle that a sphere subtends, accurate for small angles; 0 inside the sphere.
template <class F> SHEAF_INLINE F sphere_one_minus_cos(F radius, F distance_squared) {
  const F sin2 = min(radius * radius / max(distance_squared, F(1e-37f)), F(1.0f));
  return select(sin2 < F(1.0f), sin2 / (F(1.0f) + safe_sqrt(F(1.0f) - sin2)), F(0.0f));
}

struct SphereLight {
  using Kind = SphereLightKind;
  static constexpr LightHitKind kHitKind = LightHitKind::kSurface;

  template <class L, ColorMode kMode>
  static SHEAF_INLINE LightSample<L> sample(const LightQuery<L>& lights, Vec3<L> from, const Random4<L>& u,
                                            TextureQuery<L>& texture) {
    using F = Float<L>;
    using U = Uint<L>;
    const SphereLightData<L> sphere = lights.light.template data<SphereLightData>();
    const Vec3<L> to_center = sphere.center - from;
    const F squared = dot(to_center, to_center);
    const F one_minus_cos_max = sphere_one_minus_cos(sphere.radius, squared);
    LightSample<L> s;
    s.valid = (one_minus_cos_max > F(0.0f)) & !lights.light.is_along_normal();
    const F distance = sqrt(max(squared, F(1e-37f)));
    const auto frame = Frame<L>::from_normal(to_center * (F(1.0f) / distance));
    const Vec3<L> local = square_to_cone<L>(u.y, u.z, one_minus_cos_max);
    s.direction = frame.to_world(local);
    // Normal at the first intersection of the direction with the sphere.
    const F sin2 = max(F(0.0f), F(1.0f) - local.z * local.z);
    const F along = distance * local.z - safe_sqrt(sphere.radius * sphere.radius - squared * sin2);
    const Vec3<L> normal = (s.direction * along - to_center) * (F(1.0f) / sphere.radius);
    const F extent = max_component(abs(sphere.center)) + sphere.radius;
    const F n_length = sqrt(max(dot(normal, normal), F(1e-12f)));
    const F offset = max(F(2.0f * kOffsetUlps) * extent, select(lights.active, sphere.surface.min_offset, F(0.0f)));
    s.target = sphere.center + normal * ((sphere.radius + offset) / n_length);
    // Look up the texture coordinates.
    const auto textured = lights.active & lights.light.needs_texture_query();
    if (any(textured)) {
      const auto q = gather_rows<L>(lights.scene.geometry.quadrics, select(textured, sphere.surface.quadric, U(0u)));
      const Vec3<L> x = q.object_point(sphere.center + normal * (sphere.radius / n_length));
      set_quadric_query<L>(textured, q, sphere.surface, normalize_any(x), texture);
    }
    s.pdf_solid_angle = F(0.5f * kInvPi) / select(s.valid, one_minus_cos_max, F(1.0f));
    s.radiance = lights.light.radiance;
    s.normal = normal * (F(1.0f) / n_length);
    return s;
  }

  template <class L> static SHEAF_INLINE Float<L> pdf_solid_angle(const LightQuery<L>& lights, const LightHit<L>& hit) {
    using F = Float<L>;
    const SphereLightData<L> sphere = lights.light.template data<SphereLightData>();
    const Vec3<L> to_center = sphere.center - hit.from;
    const F one_minus_cos_max = sphere_one_minus_cos(sphere.radius, dot(to_center, to_center));
    const auto outside = one_minus_cos_max > F(0.0f);
    return select(outside, F(0.5f * kInvPi) / select(outside, one_minus_cos_max, F(1.0f)), F(0.0f));
  }

  template <class L, ColorMode kMode>
  static SHEAF_INLINE PhotonEmission<L> emit(const LightQuery<L>& lights, const Random4<L>& a, const Random4<L>& b,
                                             TextureQuery<L>& texture) {
    const SphereLightData<L> sphere = lights.light.template data<SphereLightData>();
    return emit_from<L>(point_on_quadric<L>(lights, sphere.surface, a, texture), lights.light, b);
  }
};

template <> struct LightOf<SphereLightKind> { using Type = SphereLight; };

}  // namespace sheaf
