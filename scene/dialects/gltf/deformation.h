// Deformation of the meshes of glTF nodes by skins and morph targets: in a pose, and while the shutter is open.
#pragma once

#include "scene/dialects/gltf/node_motion.h"
#include "scene/dialects/gltf/reader.h"

#include <map>

namespace sheaf::gltf {

/// The morph weights of a node, which must have a mesh.
const std::vector<float>& weights_of(const GltfFile& file, const Pose& pose, std::size_t node);

/// The origin of a node's skin: its first joint. Vertices are computed relative to it, because floats cannot hold their
/// digits far from the origin. Zero without a skin.
Vec3d skin_origin(const GltfFile& file, const Pose& pose, std::size_t node);

/// Deformation of the mesh of a node by a pose. `origin`: see skin_origin().
Deformation deformation_of(const GltfFile& file, const Pose& pose, std::size_t node, Vec3d origin);

/// The meshes of nodes that deform while the shutter is open.
class Deformations {
 public:
  Deformations(GltfFile& file, const AnimationTime& moment, const ShutterDescription& shutter, bool lenient);

  /// Whether meshes() applies to a node.
  bool deforms(std::size_t node) const { return deforms_[node]; }
  /// The primitives of load_mesh() for a node, in the same order, with keys at equidistant times. The number of keys
  /// follows from the error of linear interpolation in between. Skins are relative to their origin at the first time.
  std::vector<DeformingMesh> meshes(std::size_t node);

 private:
  /// The primitives at time `index` / kMaxSegments of the shutter interval.
  std::vector<Primitive> primitives_at(std::size_t node, int index);

  GltfFile& file_;
  AnimationTime moment_;
  ShutterDescription shutter_;
  bool lenient_;
  std::vector<bool> deforms_;
  std::map<int, Pose> poses_;  ///< by index
};

}  // namespace sheaf::gltf
