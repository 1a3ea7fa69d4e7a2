// Transforms and morph weights of the nodes of a glTF file at a moment.
#pragma once

#include "scene/dialects/gltf/read_gltf.h"
#include "scene/formats/gltf.h"

namespace sheaf::gltf {

/// The state of each node.
struct Pose {
  std::vector<Matrix4> to_world;
  std::vector<std::vector<float>> weights;  ///< of morph targets; empty: those of the mesh
};

/// Evaluates an animation. Before its first and after its last key it stands still. Throws SceneError if the animation
/// does not exist or its accessors do not match.
Pose pose_at(const GltfFile& file, const ModelMoment& moment);

/// The matrix of a translation, a rotation and a scale.
Matrix4 matrix_of(const GltfPose& pose);

}  // namespace sheaf::gltf
