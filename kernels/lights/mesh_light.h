// Emissive triangle meshes, sampled uniformly by area. Meshes that deform select triangles by their mean areas over the
// shutter, and sample a point of the triangle uniformly by its area at the path's time.
#pragma once

#include "core/sampling/alias_table.h"
#include "kernels/lights/area_light.h"
#include "scene/lights/mesh_light.h"

namespace sheaf {

struct MeshLight {
  using Kind = MeshLightKind;
  static constexpr LightHitKind kHitKind = LightHitKind::kSurface;
  static constexpr bool kIsSampledInline = true;

  template <class L, ColorMode kMode>
  static SHEAF_INLINE LightSample<L> sample(const LightQuery<L>& lights, Vec3<L> from, const Random4<L>& u,
                                            TextureQuery<L>& texture) {
    return sample_towards<L>(from, point<L>(lights, u, texture), lights.light);
  }

  template <class L> static SHEAF_INLINE Float<L> pdf_solid_angle(const LightQuery<L>& lights, const LightHit<L>& hit) {
    const MeshLightData<L> mesh = lights.light.template data<MeshLightData>();
    Float<L> pdf_area = Float<L>(1.0f) / mesh.area;
    if (lights.scene.motion.deformations != nullptr) {
      LightTriangleRecord<L> triangle{};
      deform<L>(lights, mesh, hit.primitive, triangle, pdf_area);
    }
    return pdf_seen<L>(pdf_area, hit);
  }

  template <class L, ColorMode kMode>
  static SHEAF_INLINE PhotonEmission<L> emit(const LightQuery<L>& lights, const Random4<L>& a, const Random4<L>& b,
                                             TextureQuery<L>& texture) {
    return emit_from<L>(point<L>(lights, a, texture), lights.light, b);
  }

 private:
  /// Replaces triangles `index` of meshes that deform, and the pdfs of their points per area, by those at the time of
  /// the query.
  template <class L>
  [[gnu::noinline]] static void deform(const LightQuery<L>& lights, const MeshLightData<L>& mesh, Uint<L> index,
                                       LightTriangleRecord<L>& triangle, Float<L>& pdf_area) {
    using F = Float<L>;
    using U = Uint<L>;
    // Find the segment
    const SceneView& scene = lights.scene;
    const U flags = gather_member<L>(scene.geometry.shapes, &ShapeRow::flags, select(lights.active, mesh.shape, U(0u)));
    const DeformationSegment<L> segment = deformation_segment<L>(scene.motion, flags, lights.active, lights.time);
    const auto deforms = segment.deforms;
    if (!any(deforms)) return;
    const U first = select(deforms, mesh.first_triangle + index, U(0u));
    const U row = first + select(deforms, segment.step * mesh.triangle_count, U(0u));
    const auto a = gather_rows<L>(scene.lights.triangles, row);
    const auto b = gather_rows<L>(scene.lights.triangles, row + select(deforms, mesh.triangle_count, U(0u)));
    // Interpolate the vertices
    LightTriangleRecord<L> now = a;
    const Vec3<L> change = b.p - a.p, change1 = b.edge1 - a.edge1, change2 = b.edge2 - a.edge2;
    now.p = a.p + change * segment.t;
    now.edge1 = a.edge1 + change1 * segment.t;
    now.edge2 = a.edge2 + change2 * segment.t;
    // Compute the normal, on the same side of the winding as that of the step, and the area
    const Vec3<L> twice = cross(now.edge1, now.edge2);
    const F twice_area = length(twice);
    const F sign = copysign(F(1.0f), dot(cross(a.edge1, a.edge2), a.normal) + dot(cross(b.edge1, b.edge2), b.normal));
    now.normal = twice * (sign / max(twice_area, F(1e-37f)));
    const Vec3<L> speed = abs(change) + abs(change1) + abs(change2);
    now.offset = max(a.offset, b.offset) + dot(abs(now.normal), speed) * segment.segments * F(kOffsetUlps);
    triangle.p = select<L>(deforms, now.p, triangle.p);
    triangle.edge1 = select<L>(deforms, now.edge1, triangle.edge1);
    triangle.edge2 = select<L>(deforms, now.edge2, triangle.edge2);
    triangle.normal = select<L>(deforms, now.normal, triangle.normal);
    triangle.offset = select(deforms, now.offset, triangle.offset);
    const F probability = gather_member<L>(scene.lights.triangle_alias, &AliasEntry::pdf, first);
    pdf_area = select(deforms, F(2.0f) * probability / max(twice_area, F(1e-37f)), pdf_area);
  }

  /// Samples a point by u.y, u.z and u.w.
  template <class L>
  static SHEAF_INLINE LightPoint<L> point(const LightQuery<L>& lights, const Random4<L>& u, TextureQuery<L>& texture) {
    using F = Float<L>;
    using U = Uint<L>;
    const SceneView& scene = lights.scene;
    const MeshLightData<L> mesh = lights.light.template data<MeshLightData>();
    LightPoint<L> out;
    // Sample a triangle by area, and a point on it
    const U first = select(lights.active, mesh.first_triangle, U(0u));
    const auto chosen =
        sample_alias<L>(scene.lights.triangle_alias, first, select(lights.active, mesh.triangle_count, U(1u)), u.w);
    LightTriangleRecord<L> triangle = gather_rows<L>(scene.lights.triangles, first + chosen.index);
    out.pdf_area = F(1.0f) / mesh.area;
    if (scene.motion.deformations != nullptr) [[unlikely]] {
      // Copies, so that static meshes stay in registers
      LightTriangleRecord<L> now = triangle;
      F pdf_area = out.pdf_area;
      deform<L>(lights, mesh, chosen.index, now, pdf_area);
      triangle = now;
      out.pdf_area = pdf_area;
    }
    const Vec2<L> b = square_to_triangle<L>(u.y, u.z);
    // Compute position and normal
    out.y.p = triangle.p + triangle.edge1 * b.x + triangle.edge2 * b.y;
    out.y.ng = triangle.normal;
    out.y.offset = triangle.offset;
    // Set up the texture lookup
    const auto textured = lights.active & lights.light.needs_texture_query();
    if (any(textured)) {
      const U row = select(textured, mesh.first_uv + chosen.index, U(0u));
      const LightUvRecord<L> uvs = gather_rows<L>(scene.lights.uvs, row);
      set_query<L>(textured, {uvs.at(F(1.0f) - b.x - b.y, b.x, b.y), mesh.shape, chosen.index, b.x, b.y}, texture);
    }
    return out;
  }
};

template <> struct LightOf<MeshLightKind> { using Type = MeshLight; };

}  // namespace sheaf
