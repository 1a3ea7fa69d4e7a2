#include "scene/compile/geometry/kept_geometry.h"

#include <algorithm>
#include <cstring>
#include <functional>

namespace sheaf {

namespace {

template <class T> bool same_bytes(const T* a, std::size_t count, const std::vector<T>& b) {
  return count == b.size() && (count == 0 || std::memcmp(a, b.data(), count * sizeof(T)) == 0);
}

template <class T> bool same_bytes(const std::vector<T>& a, const std::vector<T>& b) {
  return same_bytes(a.data(), a.size(), b);
}

/// Whether two shapes refer to the same geometry, whatever their materials, lights and media.
bool same_geometry(const ShapeRow& a, const ShapeRow& b) {
  return a.kind == b.kind && ((a.flags ^ b.flags) & kUntraced) == 0 && a.first_vertex == b.first_vertex &&
         a.first_triangle == b.first_triangle && a.triangle_count == b.triangle_count;
}

}  // namespace

bool KeptGeometry::has(BvhBuild build) const {
  return !is_updatable && std::ranges::find(builds, build) != builds.end();
}

bool KeptGeometry::serves(const std::vector<BvhBuild>& needed) const {
  if (is_updatable || builds == needed) return true;
  return expects_changes &&
         std::equal(builds.begin(), builds.end(), needed.begin(), needed.end(), std::greater_equal<>());
}

std::optional<std::vector<std::uint32_t>> KeptGeometry::changed_meshes(const GeometryTables& other,
                                                                       const AccelInput& input) const {
  const auto same_range = [](const ShapeRange& a, const ShapeRange& b) {
    return a.first_shape == b.first_shape && a.shape_count == b.shape_count;
  };
  // The acceleration structure refers to the motions of the scene that it was built for
  if (input.motion.instances != nullptr || input.motion.deformations != nullptr) return {};
  if (accel == nullptr || watertight != input.watertight || ungrouped_shapes != input.shape_count ||
      tables.vertices.size() != other.vertices.size())
    return {};
  const bool same_topology =
      std::equal(groups.begin(), groups.end(), input.groups, input.groups + input.group_count, same_range) &&
      std::equal(tables.shapes.begin(), tables.shapes.end(), other.shapes.begin(), other.shapes.end(), same_geometry) &&
      same_bytes(input.vertex_counts, vertex_counts.size(), vertex_counts) &&
      same_bytes(tables.triangles, other.triangles) && same_bytes(tables.quadrics, other.quadrics) &&
      same_bytes(tables.curve_points, other.curve_points) && same_bytes(tables.curve_segments, other.curve_segments) &&
      same_bytes(tables.sdf_grids, other.sdf_grids) && same_bytes(tables.sdf_values, other.sdf_values) &&
      same_bytes(tables.sdf_cells, other.sdf_cells) && same_bytes(tables.instances, other.instances);
  if (!same_topology) return {};
  std::vector<std::uint32_t> changed;
  for (std::uint32_t i = 0; i < tables.shapes.size(); ++i) {
    const ShapeRow& shape = tables.shapes[i];
    if (static_cast<ShapeKind>(shape.kind) == ShapeKind::kMesh &&
        std::memcmp(&tables.vertices[shape.first_vertex], &other.vertices[shape.first_vertex],
                    vertex_counts[i] * sizeof(VertexRow)) != 0)
      changed.push_back(i);
  }
  return changed;
}

void keep_geometry(std::unique_ptr<Scene> scene, KeptGeometry& kept) {
  SceneTables tables = Scene::release(std::move(scene));
  if (!tables.motion.instances.empty() || !tables.motion.deformations.empty()) {
    const bool expects_changes = kept.expects_changes;
    kept = {};
    kept.expects_changes = expects_changes;
    return;
  }
  kept.accel = std::move(tables.accel);
  kept.tables = std::move(tables.geometry);
}

}  // namespace sheaf
