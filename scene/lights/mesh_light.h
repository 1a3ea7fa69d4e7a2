// Emissive triangle meshes.
#pragma once

#include "scene/tables/light.h"

namespace sheaf {

/// Data of a mesh as a light.
template <class L> struct MeshLightData {
  typename L::Uint shape;           ///< into SceneView::shapes
  typename L::Uint first_triangle;  ///< into SceneView::triangle_alias and SceneView::light_triangles
  typename L::Uint triangle_count;
  typename L::Uint first_uv;  ///< with a texture: into SceneView::light_uvs
  typename L::Float area;     ///< world space, m^2

  static constexpr auto fields(auto& s) {
    return std::tie(s.shape, s.first_triangle, s.triangle_count, s.first_uv, s.area);
  }
};

}  // namespace sheaf
