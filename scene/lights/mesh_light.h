// Emissive triangle meshes.
#pragma once

#include "scene/lights/light.h"

namespace sheaf {

/// Data of a mesh as a light.
template <class L> struct MeshLightData {
  typename L::Uint shape;           ///< into GeometryView::shapes
  typename L::Uint first_triangle;  ///< into LightView::triangle_alias and LightView::triangles
  typename L::Uint triangle_count;
  typename L::Uint first_uv;  ///< with a texture: into LightView::uvs
  typename L::Float area;     ///< world space, m^2

  static constexpr auto fields(auto& s) {
    return std::tie(s.shape, s.first_triangle, s.triangle_count, s.first_uv, s.area);
  }
};

/// See scene/lights/light.h.
struct MeshLightKind {
  static constexpr const char* kLabel = "area";
  static constexpr LightDomain kDomain = LightDomain::kBounded;
  using Descriptions = LightDescriptions<>;

  static Vec3f power(const SceneView& scene, const LightRow& light);
  static LightBounds bounds(const SceneView& scene, const LightRow& light, double power);
  static Vec3f integral(const SceneView& scene, const LightRow& light, int points);
  static IntegralSharing integral_key(const SceneView& scene, const LightRow& light, std::vector<std::uint32_t>& key);
};

}  // namespace sheaf
