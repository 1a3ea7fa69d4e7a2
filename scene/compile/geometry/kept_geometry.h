// The geometry of a scene, kept for the next frame of an animation: its acceleration structure is built once while
// geometry does not move.
#pragma once

#include "scene/scene.h"

#include <memory>
#include <optional>
#include <vector>

namespace sheaf {

/// Geometry tables with the acceleration structure that refers to them.
struct KeptGeometry {
  GeometryTables tables;
  std::vector<std::uint32_t> vertex_counts;  ///< AccelInput::vertex_counts
  std::vector<ShapeRange> groups;
  std::uint32_t ungrouped_shapes = 0;
  bool watertight = false;
  BvhLayout layout = BvhLayout::kFast;
  std::vector<BvhBuild> builds;  ///< AccelInput::builds
  std::unique_ptr<Accel> accel;  ///< null: no geometry is kept
  /// Whether changed vertices are expected: the first change builds a structure that later ones update. Structures of
  /// faster rays also serve scenes that don't need them. Both may resolve equal distances differently.
  bool expects_changes = false;
  bool is_updatable = false;  ///< AccelInput::updatable

  /// Whether the kept structure can serve a scene that needs these builds.
  bool serves(const std::vector<BvhBuild>& needed) const;
  /// Whether a structure was built by this method.
  bool has(BvhBuild build) const;
  /// Compares the kept acceleration structure with one for `input` and the tables `other`. Returns the meshes whose
  /// vertices differ; an empty list means that both structures are equal to the bit, except for layout and builds.
  /// Returns std::nullopt if anything else differs.
  std::optional<std::vector<std::uint32_t>> changed_meshes(const GeometryTables& other, const AccelInput& input) const;
};

/// Moves the geometry of a scene that was compiled with CompileOptions::kept to that object, and destroys the scene.
/// Scenes with moving geometry are not kept.
void keep_geometry(std::unique_ptr<Scene> scene, KeptGeometry& kept);

}  // namespace sheaf
