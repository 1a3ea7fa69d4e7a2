// Builds the acceleration structure of a scene, or takes a kept one.
#include "core/io/memory.h"
#include "scene/accel/build_quality.h"
#include "scene/compile/geometry/compile_geometry.h"
#include "scene/compile/geometry/kept_geometry.h"

#include <algorithm>
#include <exception>

namespace sheaf {

namespace {

struct LayoutChoice {
  BvhLayout layout;
  bool fast_serves;  ///< a kept structure with BvhLayout::kFast is as good
};

LayoutChoice choose_layout(const CompileOptions& options, SceneTables& scene) {
  if (options.bvh != BvhChoice::kAuto)
    return {options.bvh == BvhChoice::kCompact ? BvhLayout::kCompact : BvhLayout::kFast, false};
  // The compact layout takes some 0.15 us less per triangle to build, and 0.1 us more per ray
  if (!is_small_for_builds(static_cast<double>(scene.info.triangles)) &&
      options.expected_rays <= static_cast<double>(scene.info.triangles))
    return {BvhLayout::kCompact, true};
  // Upper estimate of the builder's peak per triangle: 90 bytes on 2 million triangles, more with spatial splits
  constexpr double kFastBytes = 150;
  double bytes = kFastBytes * static_cast<double>(scene.info.triangles);
  if (options.render_bytes) {
    auto unbuilt = std::make_unique<Scene>(std::move(scene));
    // Tasks beside this one refer to the rows of the tables: keep them, also after an exception
    std::exception_ptr error;
    try {
      bytes += options.render_bytes(*unbuilt);
    } catch (...) { error = std::current_exception(); }
    scene = Scene::release(std::move(unbuilt));
    if (error) std::rethrow_exception(error);
  }
  return {bytes > available_memory() ? BvhLayout::kCompact : BvhLayout::kFast, false};
}

/// Takes the kept acceleration structure and its tables if nothing or only vertices of meshes have changed.
/// `updatable`: receives whether another structure should be updatable.
bool take_kept(const AccelInput& input, bool fast_serves, KeptGeometry& kept, SceneTables& scene, bool& updatable) {
  GeometryTables& tables = scene.geometry;
  const bool has_layout = kept.layout == input.layout || (fast_serves && kept.layout == BvhLayout::kFast);
  if (!has_layout) return false;
  const auto changed = kept.changed_meshes(tables, input);
  if (!changed) return false;
  if (!changed->empty()) {
    updatable = kept.expects_changes && changed->back() < kept.ungrouped_shapes;
    if (!updatable || !kept.is_updatable) return false;
    std::copy(tables.vertices.begin(), tables.vertices.end(), kept.tables.vertices.begin());
    kept.accel->update(*changed);
  } else if (!kept.serves(input.builds)) {
    return false;
  }
  // Embree refers to the kept tables. Shapes may have other materials and lights, and vertices other tangents.
  kept.tables.shapes = std::move(tables.shapes);
  kept.tables.tangents = std::move(tables.tangents);
  tables = std::move(kept.tables);
  scene.accel = std::move(kept.accel);
  return true;
}

}  // namespace

void build_accel(const CompiledGeometry& geometry, const CompileOptions& options, SceneTables& scene) {
  const auto [layout, fast_serves] = choose_layout(options, scene);
  scene.info.bvh = layout;
  GeometryTables& tables = scene.geometry;
  AccelInput input{tables.shapes.data(),
                   geometry.ungrouped_shapes,
                   tables.vertices.data(),
                   tables.triangles.data(),
                   tables.quadrics.data(),
                   tables.curve_points.data(),
                   tables.curve_segments.data(),
                   tables.sdf_grids.data(),
                   tables.sdf_values.data(),
                   tables.sdf_cells.data(),
                   geometry.vertex_counts.data(),
                   options.watertight,
                   layout,
                   geometry.groups.data(),
                   static_cast<std::uint32_t>(geometry.groups.size()),
                   tables.instances.data(),
                   static_cast<std::uint32_t>(tables.instances.size()),
                   scene.motion.view()};
  const bool is_auto = options.bvh == BvhChoice::kAuto;
  BuildChoice choice = choose_builds(input, is_auto ? options.expected_rays : kInfinity);
  input.builds = std::move(choice.builds);
  scene.info.bvh_splits = choice.splits;
  KeptGeometry* const kept = options.kept;
  const bool expects_changes = kept != nullptr && kept->expects_changes;
  if (kept != nullptr && kept->vertex_counts.size() == geometry.vertex_counts.size() &&
      take_kept(input, fast_serves, *kept, scene, input.updatable)) {
    scene.info.bvh = kept->layout;
    if (kept->has(BvhBuild::kSpatial)) scene.info.bvh_splits = BvhSplits::kBuilt;
    scene.info.bvh_along_curve = kept->has(BvhBuild::kMorton);
    return;
  }
  if (kept != nullptr) *kept = {};  // free its memory before building
  scene.accel = std::make_unique<Accel>(input);
  scene.info.bvh_along_curve =
      !input.updatable && std::ranges::find(input.builds, BvhBuild::kMorton) != input.builds.end();
  if (kept == nullptr) return;
  kept->expects_changes = expects_changes;
  kept->is_updatable = input.updatable;
  kept->vertex_counts = geometry.vertex_counts;
  kept->groups = geometry.groups;
  kept->ungrouped_shapes = geometry.ungrouped_shapes;
  kept->watertight = options.watertight;
  kept->layout = layout;
  kept->builds = std::move(input.builds);
}

}  // namespace sheaf
