// Upper bounds of a volume on a coarse grid, for tracking that takes small steps only where the volume is dense.
#pragma once

#include "scene/tables/brick_grid.h"

namespace sheaf {

/// What kernels read of a majorant grid. Cell (i, j, k) is all of [i, i + 1) x [j, j + 1) x [k, k + 1) inside of the
/// box; those at the ends reach on to the box's faces.
struct alignas(64) MajorantGridRow {
  float world_to_cells[16] = {};  ///< columns of the 3x4 matrix, four floats each, the last of which is zero
  float box_min[3] = {}, box_max[3] = {};  ///< in cells; outside of it, `outside` bounds the volume
  const float* bounds = nullptr;           ///< of each cell, x fastest
  std::int32_t cells[3] = {};
  float outside = 0;  ///< zero: there is nothing outside
};
static_assert(sizeof(MajorantGridRow) == 128);

/// Owns the bounds of a volume.
struct MajorantGrid {
  std::array<int, 3> cells{};  ///< all 0: the volume is empty
  int bricks_per_cell = 1;     ///< along each side
  GridBox box;                 ///< in cells
  std::vector<float> bounds;   ///< x fastest; none is negative
  float outside = 0;

  /// The largest of all, `outside` among them.
  float max_value() const;
  std::size_t bytes() const { return bounds.capacity() * sizeof(float); }
};

/// Most cells along a side.
inline constexpr int kMaxMajorantSide = 64;

/// Bounds on all channels of a grid, for one way of looking it up. A cell is as many bricks as keep the longest side
/// within `max_side` cells, one if possible: a step from cell to cell costs about a fourth of a lookup, so that cells
/// much smaller than a brick cost more steps than they save lookups, while larger ones hold too much empty space.
/// Bounds are a little larger than need be, for the rounding of lookups. A place less than a rounding error from a
/// cell's face may belong to the neighbour, so kernels must get along with values that exceed the bound there.
///
/// The box is where the grid has other values than its background, which is 0 outside; grids that are clamped, repeated
/// or mirrored have the box of their voxels, and `outside` bounds what goes on around it.
MajorantGrid make_majorant_grid(const BrickGrid& grid, GridVolumeDescription::Filter filter,
                                int max_side = kMaxMajorantSide);

/// The kernels' row; both grids as given to make_majorant_grid(). The result must not outlive `majorant`. Throws
/// SceneError if the transform is singular.
MajorantGridRow make_majorant_grid_row(const MajorantGrid& majorant, const BrickGrid& grid,
                                       const Transform& local_to_world, GridVolumeDescription::Filter filter);

}  // namespace sheaf
