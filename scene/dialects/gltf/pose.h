// Transforms and morph weights of the nodes of a glTF file at a moment.
#pragma once

#include "scene/dialects/gltf/read_gltf.h"
#include "scene/formats/gltf.h"

#include <optional>

namespace sheaf::gltf {

/// The state of each node.
struct Pose {
  std::vector<Matrix4> to_world;
  /// The same with factors of scale that are zero replaced by 1: gives lights and cameras their directions.
  std::vector<Matrix4> directions;
  std::vector<std::vector<float>> weights;  ///< of morph targets; empty: those of the mesh
};

/// Evaluates an animation, which is constant before its first and after its last key. Throws SceneError if the
/// animation does not exist or its accessors do not match.
Pose pose_at(const GltfFile& file, const AnimationTime& moment);

/// An affine matrix that is invertible: a matrix that flattens space to a plane gets a small thickness, others that are
/// invertible stay as they are. Nothing for matrices that leave a line or a point.
std::optional<Matrix4> thickened(const Matrix4& matrix);

/// The matrix of a translation, a rotation and a scale.
Matrix4 matrix_of(const GltfPose& pose);

}  // namespace sheaf::gltf
