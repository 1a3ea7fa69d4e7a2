// Affine maps of vertices, by skins and by nodes.
#pragma once

#include "core/math/transform.h"
#include "scene/description/shapes.h"

#include <optional>

namespace sheaf::gltf {

/// An affine map. It may be singular: a joint with a scale of zero collapses the vertices that follow it.
class VertexMap {
 public:
  explicit VertexMap(const Matrix4& matrix);

  /// Maps the position, the normal and the tangent of a vertex. A normal becomes zero if the map collapses space to a
  /// line or a point.
  void apply(Mesh& mesh, std::size_t vertex) const;

 private:
  Matrix4 matrix_;
  std::optional<Transform> regular_;  ///< empty: singular
};

}  // namespace sheaf::gltf
