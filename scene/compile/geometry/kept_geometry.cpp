#include "scene/compile/geometry/kept_geometry.h"

#include <algorithm>
#include <cstring>

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

bool KeptGeometry::matches(const GeometryTables& other, const AccelInput& input) const {
  const auto same_range = [](const ShapeRange& a, const ShapeRange& b) {
    return a.first_shape == b.first_shape && a.shape_count == b.shape_count;
  };
  // The acceleration structure refers to the motions of the scene that it was built for
  if (input.motion.instances != nullptr || input.motion.deformations != nullptr) return false;
  if (accel == nullptr || watertight != input.watertight || layout != input.layout ||
      ungrouped_shapes != input.shape_count)
    return false;
  return std::equal(groups.begin(), groups.end(), input.groups, input.groups + input.group_count, same_range) &&
         std::equal(tables.shapes.begin(), tables.shapes.end(), other.shapes.begin(), other.shapes.end(),
                    same_geometry) &&
         same_bytes(input.vertex_counts, vertex_counts.size(), vertex_counts) &&
         same_bytes(tables.vertices, other.vertices) && same_bytes(tables.triangles, other.triangles) &&
         same_bytes(tables.quadrics, other.quadrics) && same_bytes(tables.curve_points, other.curve_points) &&
         same_bytes(tables.curve_segments, other.curve_segments) && same_bytes(tables.sdf_grids, other.sdf_grids) &&
         same_bytes(tables.sdf_values, other.sdf_values) && same_bytes(tables.sdf_cells, other.sdf_cells) &&
         same_bytes(tables.instances, other.instances);
}

void keep_geometry(std::unique_ptr<Scene> scene, KeptGeometry& kept) {
  SceneTables tables = Scene::release(std::move(scene));
  if (!tables.motion.instances.empty() || !tables.motion.deformations.empty()) {
    kept = {};
    return;
  }
  kept.accel = std::move(tables.accel);
  kept.tables = std::move(tables.geometry);
}

}  // namespace sheaf
