// Spheres that emit outwards, sampled uniformly in the cone of directions that they subtend (Pharr et al. 2023, section
// 6.2.4).
#pragma once

#include "kernels/lights/quadric_light.h"

namespace sheaf {

/// 1 - cos of the half angle that a sphere subtends, accurate for small angles; 0 inside the sphere.
template <class F> SHEAF_INLINE F sphere_one_minus_cos(F radius, F distance_squared) {
  const F sin2 = min(radius * radius / max(distance_squared, F(1e-37f)), F(1.0f));
  return select(sin2 < F(1.0f), sin2 / (F(1.0f) + safe_sqrt(F(1.0f) - sin2)), F(0.0f));
}

struct SphereLight {
  static constexpr LightKind kKind = LightKind::kSphere;
  static constexpr LightHitKind kHitKind = LightHitKind::kSurface;

  template <class L, ColorMode Mode>
  static SHEAF_INLINE LightSample<L> sample(const LightQuery<L>& lights, Vec3<L> from, const Random4<L>& u,
                                            TextureQuery<L>& texture) {
    using F = Float<L>;
    using U = Uint<L>;
    const LightRecord<L>& light = lights.light;
    const Vec3<L> to_center = light.position - from;
    const F squared = dot(to_center, to_center);
    const F one_minus_cos_max = sphere_one_minus_cos(light.radius, squared);
    LightSample<L> s;
    s.valid = (one_minus_cos_max > F(0.0f)) & !light.is_along_normal();
    const F distance = sqrt(max(squared, F(1e-37f)));
    const auto frame = Frame<L>::from_normal(to_center * (F(1.0f) / distance));
    const Vec3<L> local = square_to_cone<L>(u.y, u.z, one_minus_cos_max);
    s.direction = frame.to_world(local);
    // Normal at the first intersection of the direction with the sphere.
    const F sin2 = max(F(0.0f), F(1.0f) - local.z * local.z);
    const F along = distance * local.z - safe_sqrt(light.radius * light.radius - squared * sin2);
    const Vec3<L> normal = (s.direction * along - to_center) * (F(1.0f) / light.radius);
    const F extent = max_component(abs(light.position)) + light.radius;
    const F n_length = sqrt(max(dot(normal, normal), F(1e-12f)));
    const F offset = max(F(2.0f * kOffsetUlps) * extent, select(lights.active, light.least_offset(), F(0.0f)));
    s.target = light.position + normal * ((light.radius + offset) / n_length);
    // Look up the texture coordinates.
    const auto textured = lights.active & (light.texture != U(kNone));
    if (any(textured)) {
      const auto q = gather_rows<L>(lights.scene.geometry.quadrics, select(textured, light.quadric(), U(0u)));
      const Vec3<L> x = q.object_point(light.position + normal * (light.radius / n_length));
      set_quadric_query<L>(textured, q, light, normalize_any(x), texture);
    }
    s.pdf_solid_angle = F(0.5f * kInvPi) / select(s.valid, one_minus_cos_max, F(1.0f));
    s.radiance = light.radiance;
    return s;
  }

  template <class L> static SHEAF_INLINE Float<L> pdf_solid_angle(const LightQuery<L>& lights, const LightHit<L>& hit) {
    using F = Float<L>;
    const Vec3<L> to_center = lights.light.position - hit.from;
    const F one_minus_cos_max = sphere_one_minus_cos(lights.light.radius, dot(to_center, to_center));
    const auto outside = one_minus_cos_max > F(0.0f);
    return select(outside, F(0.5f * kInvPi) / select(outside, one_minus_cos_max, F(1.0f)), F(0.0f));
  }

  template <class L, ColorMode Mode>
  static SHEAF_INLINE PhotonEmission<L> emit(const LightQuery<L>& lights, const Random4<L>& a, const Random4<L>& b,
                                             TextureQuery<L>& texture) {
    return emit_from<L>(point_on_quadric<L>(lights, a, texture), lights.light, b);
  }
};

}  // namespace sheaf
