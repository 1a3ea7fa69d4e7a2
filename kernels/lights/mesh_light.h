// Emissive triangle meshes, sampled uniformly by area.
#pragma once

#include "core/alias_table.h"
#include "kernels/lights/area_light.h"
#include "scene/lights/mesh_light.h"

namespace sheaf {

struct MeshLight {
  using Kind = MeshLightKind;
  static constexpr LightHitKind kHitKind = LightHitKind::kSurface;

  template <class L, ColorMode kMode>
  static SHEAF_INLINE LightSample<L> sample(const LightQuery<L>& lights, Vec3<L> from, const Random4<L>& u,
                                            TextureQuery<L>& texture) {
    return sample_towards<L>(from, point<L>(lights, u, texture), lights.light);
  }

  template <class L> static SHEAF_INLINE Float<L> pdf_solid_angle(const LightQuery<L>& lights, const LightHit<L>& hit) {
    return pdf_seen<L>(Float<L>(1.0f) / lights.light.template data<MeshLightData>().area, hit);
  }

  template <class L, ColorMode kMode>
  static SHEAF_INLINE PhotonEmission<L> emit(const LightQuery<L>& lights, const Random4<L>& a, const Random4<L>& b,
                                             TextureQuery<L>& texture) {
    return emit_from<L>(point<L>(lights, a, texture), lights.light, b);
  }

 private:
  /// Samples a point by u.y, u.z and u.w.
  template <class L>
  static SHEAF_INLINE LightPoint<L> point(const LightQuery<L>& lights, const Random4<L>& u, TextureQuery<L>& texture) {
    using F = Float<L>;
    using U = Uint<L>;
    const SceneView& scene = lights.scene;
    const MeshLightData<L> mesh = lights.light.template data<MeshLightData>();
    // Sample a triangle by area, and a point on it
    const U first = select(lights.active, mesh.first_triangle, U(0u));
    const auto chosen =
        sample_alias<L>(scene.lights.triangle_alias, first, select(lights.active, mesh.triangle_count, U(1u)), u.w);
    const LightTriangleRecord<L> triangle = gather_rows<L>(scene.lights.triangles, first + chosen.index);
    const Vec2<L> b = square_to_triangle<L>(u.y, u.z);
    // Compute position and normal
    LightPoint<L> out;
    out.y.p = triangle.p + triangle.edge1 * b.x + triangle.edge2 * b.y;
    out.y.ng = triangle.normal;
    out.y.offset = triangle.offset;
    // Set up the texture lookup
    const auto textured = lights.active & (lights.light.texture != U(kNone));
    if (any(textured)) {
      const U row = select(textured, mesh.first_uv + chosen.index, U(0u));
      const LightUvRecord<L> uvs = gather_rows<L>(scene.lights.uvs, row);
      set_query<L>(textured, {uvs.at(F(1.0f) - b.x - b.y, b.x, b.y), mesh.shape, chosen.index, b.x, b.y}, texture);
    }
    out.pdf_area = F(1.0f) / mesh.area;
    return out;
  }
};

template <> struct LightOf<MeshLightKind> { using Type = MeshLight; };

}  // namespace sheaf
