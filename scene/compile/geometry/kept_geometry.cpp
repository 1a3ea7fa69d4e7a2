#include "scene/compile/geometry/kept_geometry.h"

#include "scene/compile/scene_compiler.h"

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

BvhLayout SceneCompiler::choose_layout() {
  if (options_.bvh != BvhChoice::kAuto)
    return options_.bvh == BvhChoice::kCompact ? BvhLayout::kCompact : BvhLayout::kFast;
  // Upper estimate of the builder's peak per triangle: 90 bytes on 2 million triangles, more with spatial splits
  constexpr double kFastBytes = 150;
  double bytes = kFastBytes * static_cast<double>(out_->counts_.triangles);
  if (options_.render_bytes) {
    out_->view_ = out_->make_view();
    bytes += options_.render_bytes(*out_);
  }
  return bytes > available_memory() ? BvhLayout::kCompact : BvhLayout::kFast;
}

void SceneCompiler::build_accel() {
  const SecondsTimer timer(times_.accel_seconds);
  const BvhLayout layout = choose_layout();
  out_->counts_.bvh = layout;
  GeometryTables& geometry = out_->geometry_;
  const AccelInput input{geometry.shapes.data(),
                         ungrouped_shapes_,
                         geometry.vertices.data(),
                         geometry.triangles.data(),
                         geometry.quadrics.data(),
                         geometry.curve_points.data(),
                         geometry.curve_segments.data(),
                         geometry.sdf_grids.data(),
                         geometry.sdf_values.data(),
                         geometry.sdf_cells.data(),
                         vertex_counts_.data(),
                         options_.watertight,
                         layout,
                         group_ranges_.data(),
                         static_cast<std::uint32_t>(group_ranges_.size()),
                         geometry.instances.data(),
                         static_cast<std::uint32_t>(geometry.instances.size()),
                         out_->motion_.view()};
  KeptGeometry* const kept = options_.kept;
  if (kept != nullptr && kept->vertex_counts.size() == vertex_counts_.size() && kept->matches(geometry, input)) {
    // Embree refers to the kept tables. Shapes may have other materials and lights, and vertices other tangents.
    kept->tables.shapes = std::move(geometry.shapes);
    kept->tables.tangents = std::move(geometry.tangents);
    geometry = std::move(kept->tables);
    out_->accel_ = std::move(kept->accel);
    return;
  }
  if (kept != nullptr) *kept = {};  // free its memory before building
  out_->accel_ = std::make_unique<Accel>(input);
  if (kept == nullptr) return;
  kept->vertex_counts = vertex_counts_;
  kept->groups = group_ranges_;
  kept->ungrouped_shapes = ungrouped_shapes_;
  kept->watertight = options_.watertight;
  kept->layout = layout;
}

void SceneCompiler::keep_geometry(Scene& scene, KeptGeometry& kept) {
  if (!scene.motion_.instances.empty() || !scene.motion_.deformations.empty()) {
    kept = {};
    return;
  }
  kept.accel = std::move(scene.accel_);
  kept.tables = std::move(scene.geometry_);
}

void keep_geometry(std::unique_ptr<Scene> scene, KeptGeometry& kept) { SceneCompiler::keep_geometry(*scene, kept); }

}  // namespace sheaf
