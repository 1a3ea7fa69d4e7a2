// Emissive rectangles: meshes of two triangles that form one and do not deform.
#pragma once

#include "scene/lights/mesh_light.h"

namespace sheaf {

/// Data of a rectangle as a light. They begin with those of a mesh. In LightView::triangles, both triangles begin with
/// the vertex at their right angle.
template <class L> struct RectangleLightData {
  MeshLightData<L> mesh;
  typename L::Uint right_angle0;  ///< the vertex at the right angle of the shape's triangle 0: 0, 1 or 2
  typename L::Uint right_angle1;  ///< that of triangle 1

  static constexpr auto fields(auto& s) { return std::tie(s.mesh, s.right_angle0, s.right_angle1); }
};

/// See scene/lights/light.h.
struct RectangleLightKind : MeshLightKind {};

}  // namespace sheaf
