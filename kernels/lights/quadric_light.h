// Emissive disks and cylinders, and spheres that are stretched or emit inwards. Sampled uniformly over the canonical
// shape.
#pragma once

#include "kernels/lights/area_light.h"
#include "scene/lights/quadric_light.h"

namespace sheaf {

/// Texture coordinates at the point `x` of the canonical shape. Not inlined, because textured quadrics are rare.
template <class L>
void set_quadric_query(Mask<L> m, const QuadricRecord<L>& q, const QuadricLightData<L>& light, Vec3<L> x,
                       TextureQuery<L>& texture) {
  using F = Float<L>;
  const auto y = quadric_surface<L, true>(q, static_cast<Uint<L>>(q.kind), x);
  set_query<L>(m, {y.uv, light.shape, Uint<L>(0u), F(0.0f), F(0.0f)}, texture);
}

/// Samples a point uniformly on the canonical shape of a quadric, spheres included, by u.y and u.z.
template <class L>
SHEAF_INLINE LightPoint<L> point_on_quadric(const LightQuery<L>& lights, const QuadricLightData<L>& light,
                                            const Random4<L>& u, TextureQuery<L>& texture) {
  using F = Float<L>;
  using U = Uint<L>;
  const auto q = gather_rows<L>(lights.scene.geometry.quadrics, select(lights.active, light.quadric, U(0u)));
  const U kind = static_cast<Uint<L>>(q.kind);
  const Vec3<L> on_sphere = square_to_sphere<L>(u.y, u.z);
  const Vec2<L> on_disk = square_to_disk<L>(u.y, u.z);
  const auto angle = sincos_2pi<L>(u.y);
  const auto disk = kind == U(static_cast<std::uint32_t>(ShapeKind::kDisk));
  const auto cylinder = kind == U(static_cast<std::uint32_t>(ShapeKind::kCylinder));
  Vec3<L> x = select<L>(disk, {on_disk.x, on_disk.y, F(0.0f)}, on_sphere);
  x = select<L>(cylinder, {angle.cos, angle.sin, u.z}, x);
  LightPoint<L> out;
  out.y = quadric_surface<L, false>(q, kind, x);
  out.y.offset = max(out.y.offset, select(lights.active, light.min_offset, F(0.0f)));
  const auto textured = lights.active & lights.light.needs_texture_query();
  if (any(textured)) set_quadric_query<L>(textured, q, light, x, texture);
  // The transformation scales the area element by |det| |M^-T n|.
  const Vec3<L> n = {select(disk, F(0.0f), x.x), select(disk, F(0.0f), x.y),
                     select(disk, F(1.0f), select(cylinder, F(0.0f), x.z))};
  out.pdf_area = F(1.0f) / max(light.canonical_area * q.determinant * length(q.world_normal(n)), F(1e-37f));
  return out;
}

struct QuadricLight {
  using Kind = QuadricLightKind;
  static constexpr LightHitKind kHitKind = LightHitKind::kSurface;

  template <class L, ColorMode kMode>
  static SHEAF_INLINE LightSample<L> sample(const LightQuery<L>& lights, Vec3<L> from, const Random4<L>& u,
                                            TextureQuery<L>& texture) {
    return sample_towards<L>(from, point_on_quadric<L>(lights, data<L>(lights), u, texture), lights.light);
  }

  template <class L> static SHEAF_INLINE Float<L> pdf_solid_angle(const LightQuery<L>& lights, const LightHit<L>& hit) {
    using F = Float<L>;
    const QuadricLightData<L> light = data<L>(lights);
    const auto q = gather_rows<L>(lights.scene.geometry.quadrics, select(lights.active, light.quadric, Uint<L>(0u)));
    // M^-T n| for the canonical unit normal n equals 1 / |M^T ng|.
    const Vec3<L> ng = hit.ng;
    const auto* m = q.to_world;
    const Vec3<L> back{m[0] * ng.x + m[4] * ng.y + m[8] * ng.z, m[1] * ng.x + m[5] * ng.y + m[9] * ng.z,
                       m[2] * ng.x + m[6] * ng.y + m[10] * ng.z};
    return pdf_seen<L>(length(back) / max(light.canonical_area * q.determinant, F(1e-37f)), hit);
  }

  template <class L, ColorMode kMode>
  static SHEAF_INLINE PhotonEmission<L> emit(const LightQuery<L>& lights, const Random4<L>& a, const Random4<L>& b,
                                             TextureQuery<L>& texture) {
    return emit_from<L>(point_on_quadric<L>(lights, data<L>(lights), a, texture), lights.light, b);
  }

 private:
  template <class L> static SHEAF_INLINE QuadricLightData<L> data(const LightQuery<L>& lights) {
    return lights.light.template data<QuadricLightData>();
  }
};

template <> struct LightOf<QuadricLightKind> { using Type = QuadricLight; };

}  // namespace sheaf
