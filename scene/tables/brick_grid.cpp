// Bounds of brick grids, and their rows for kernels.
#include "scene/tables/brick_grid.h"

#include "core/io/error.h"

#include <algorithm>
#include <cmath>

namespace sheaf {

namespace {

/// Distance in voxels by which the outermost values extend beyond their positions.
double margin_of(const BrickGrid& grid, GridFilter filter) {
  return grid.border == GridBorder::kBackground && filter == GridFilter::kTrilinear ? 1.0 : 0.5;
}

}  // namespace

Bounds3f BrickGrid::voxel_box() const {
  Bounds3f box = Bounds3f::empty();
  if (is_empty()) return box;
  const auto& m = grid_to_local.matrix().m;
  for (unsigned corner = 0; corner < 8; ++corner) {
    float p[3];
    for (std::size_t row = 0; row < 3; ++row) {
      double sum = m[row][3];
      for (std::size_t axis = 0; axis < 3; ++axis)
        sum += m[row][axis] * ((corner >> axis & 1u) != 0 ? voxel_max[axis] + 0.5 : voxel_min[axis] - 0.5);
      p[row] = static_cast<float>(sum);
    }
    box.grow(Vec3f{p[0], p[1], p[2]});
  }
  return box;
}

Bounds3f row_box(const BrickGrid& grid, GridFilter filter) {
  if (grid.is_empty()) return Bounds3f::empty();
  const double margin = margin_of(grid, filter), shift = filter == GridFilter::kNearest ? 0.5 : 0.0;
  float lo[3], hi[3];
  for (std::size_t axis = 0; axis < 3; ++axis) {
    lo[axis] = static_cast<float>(grid.voxel_min[axis] - grid.first[axis] - margin + shift);
    hi[axis] = static_cast<float>(grid.voxel_max[axis] - grid.first[axis] + margin + shift);
  }
  return {{lo[0], lo[1], lo[2]}, {hi[0], hi[1], hi[2]}};
}

BrickGridRow make_brick_grid_row(const BrickGrid& grid, const Transform& local_to_world, GridFilter filter) {
  BrickGridRow row;
  const Matrix4 to_index = (local_to_world * grid.grid_to_local).inverse().matrix();
  const double shift = filter == GridFilter::kNearest ? 0.5 : 0.0;
  for (std::size_t r = 0; r < 3; ++r) {
    for (std::size_t c = 0; c < 4; ++c) row.world_to_grid[4 * c + r] = static_cast<float>(to_index.m[r][c]);
    row.world_to_grid[12 + r] = static_cast<float>(to_index.m[r][3] - grid.first[r] + shift);
    row.cells[r] = static_cast<std::uint32_t>(grid.cells[r]);
  }
  for (const float entry : row.world_to_grid)
    if (!std::isfinite(entry)) throw SceneError("the transform of a volume is not invertible");
  row.entries = grid.entries.data();
  row.values = grid.values.data();
  row.stride_y = static_cast<std::uint32_t>(grid.bricks[0]);
  row.stride_z = static_cast<std::uint32_t>(grid.bricks[0] * grid.bricks[1]);
  row.channels = static_cast<std::uint32_t>(grid.channels);
  row.border = grid.border;
  row.nearest = filter == GridFilter::kNearest;
  std::copy_n(grid.background.begin(), 3, row.background);
  return row;
}

}  // namespace sheaf
