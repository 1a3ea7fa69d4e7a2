// Adds grids of signed distances to the geometry of a scene.
#include "scene/accel/sdf_grid.h"
#include "scene/compile/geometry/compiled_geometry.h"
#include "scene/description/voxels.h"

#include <cmath>

namespace sheaf {

namespace {

/// Throws SceneError for invalid grids and unsupported properties.
void check_sdf_grid(const ShapeDescription& shape, const SdfGrid& grid) {
  if (shape.radiance) throw SceneError("an SDF grid cannot emit light (expected no <emitter>)");
  std::size_t count = 1;
  for (const int side : grid.size) {
    if (side < 2 || side > kMaxGridSide)
      throw SceneError(fmt::format("an SDF grid has {} points along an axis (expected 2 to {})", side, kMaxGridSide));
    count *= static_cast<std::size_t>(side);
  }
  if (grid.values.size() != count)
    throw SceneError(fmt::format("an SDF grid has {} values (expected {})", grid.values.size(), count));
  for (const float value : grid.values)
    if (!std::isfinite(value)) throw SceneError("an SDF grid has values that are not finite");
}

/// Transform from the space in which cells are unit cubes to world space.
Transform grid_to_world(const ShapeDescription& shape, const SdfGrid& grid) {
  const auto width = [&](std::size_t axis) { return 1.0f / static_cast<float>(grid.size[axis] - 1); };
  return shape.to_world * Transform::scale({width(0), width(1), width(2)});
}

}  // namespace

std::optional<AddedShape> add_sdf_grid(const ShapeDescription& shape, const SdfGrid& grid, CompiledGeometry& out) {
  check_sdf_grid(shape, grid);
  GeometryTables& geometry = out.tables;
  constexpr std::size_t kMax = std::size_t{1} << 30;  // signed 32-bit indices address all values
  if (geometry.sdf_values.size() + grid.values.size() > kMax)
    throw SceneError(fmt::format("more than {} values of SDF grids in all", kMax));
  // Lay out the grid
  const QuadricRow placement = make_quadric(ShapeKind::kSdfGrid, grid_to_world(shape, grid), shape.flip_normals);
  const auto side = [&](std::size_t axis) { return static_cast<std::uint32_t>(grid.size[axis]); };
  SdfGridRow rows{};
  rows.size_x = side(0), rows.size_y = side(1), rows.size_z = side(2);
  rows.layer = rows.size_x * rows.size_y;
  rows.first_value = static_cast<std::uint32_t>(geometry.sdf_values.size());
  rows.first_cell = static_cast<std::uint32_t>(geometry.sdf_cells.size() / 2);
  rows.smooth = grid.smooth_normals ? 1 : 0;
  // Find and bound the cells with a surface
  std::vector<std::uint32_t> cells;
  for (std::uint32_t z = 0; z + 1 < rows.size_z; ++z)
    for (std::uint32_t y = 0; y + 1 < rows.size_y; ++y)
      for (std::uint32_t x = 0; x + 1 < rows.size_x; ++x)
        if (holds_surface(rows, grid.values.data(), x, y, z)) cells.insert(cells.end(), {x | y << 16, z});
  rows.cell_count = static_cast<std::uint32_t>(cells.size() / 2);
  AddedShape added{{}, Bounds3f::empty()};
  const SdfGridView view{&placement, &rows, grid.values.data(), cells.data()};
  for (std::uint32_t cell = 0; cell < rows.cell_count; ++cell) added.box.grow(sdf_cell_bounds(view, cell));
  // Drop grids without a usable surface
  if (cells.empty()) {
    out.warn(shape, "the SDF grid has no surface, because its values never change sign: left out");
    return std::nullopt;
  }
  if (geometry.sdf_cells.size() + cells.size() > kMax)
    throw SceneError(fmt::format("more than {} cells with a surface in all", kMax / 2));
  if (!is_traceable(added.box) || !(placement.determinant > 0.0f)) {
    out.warn(shape, "shape is degenerate or too large for single precision: left out");
    return std::nullopt;
  }
  // Append the grid
  ShapeRow& row = added.row;
  row.kind = static_cast<std::uint32_t>(ShapeKind::kSdfGrid);
  row.first_triangle = static_cast<std::uint32_t>(geometry.quadrics.size());
  row.first_vertex = static_cast<std::uint32_t>(geometry.sdf_grids.size());
  row.triangle_count = rows.cell_count;
  geometry.quadrics.push_back(placement);
  geometry.sdf_grids.push_back(rows);
  geometry.sdf_values.insert(geometry.sdf_values.end(), grid.values.begin(), grid.values.end());
  geometry.sdf_cells.insert(geometry.sdf_cells.end(), cells.begin(), cells.end());
  out.info.sdf_cells += rows.cell_count;
  return added;
}

}  // namespace sheaf
