// Bounds of a volume from above and below in cells of many sizes, for tracking that takes small steps only where the
// volume varies and matters.
//
// The volume is cut into base cells of a power of two voxels; a table of them says which leaf each lies in, or how
// finely it is cut: a leaf is a cube of 2^k voxels, aligned to its size, of many base cells, of one, or of a part.
#pragma once

#include "scene/tables/brick_grid.h"

#include <span>

namespace sheaf {

/// Bounds on a volume's values in a leaf.
struct MajorantBounds {
  float majorant = 0;  ///< not negative
  float minorant = 0;  ///< in [0, majorant]
};

/// An entry of the table of base cells: in the low bits the binary logarithm of the side of its leaves, in voxels; in
/// the others the index of its first leaf's bounds. Leaves that a base cell is cut into lie x fastest.
inline constexpr int kMajorantSideBits = 5;

/// What kernels read of a majorant grid. Coordinates are those of BrickGridRow::world_to_grid. Base cell (i, j, k)
/// begins at 2^base_log2 times that; those at the ends reach on to the box's faces.
struct alignas(64) MajorantGridRow {
  float world_to_grid[16] = {};            ///< columns of the 3x4 matrix, four floats each, the last of which is zero
  float box_min[3] = {}, box_max[3] = {};  ///< in voxels; outside of it, `outside` bounds the volume
  const std::uint32_t* entries = nullptr;  ///< of each base cell, x fastest
  const MajorantBounds* bounds = nullptr;  ///< of the leaves
  std::uint32_t cells[3] = {};             ///< base cells
  std::uint32_t base_log2 = 0;             ///< of a base cell's side, in voxels
  MajorantBounds outside;                  ///< zeros: there is nothing outside
};
static_assert(sizeof(MajorantGridRow) == 128);

/// Owns the bounds of a volume.
struct MajorantGrid {
  std::array<int, 3> cells{};  ///< base cells; all 0: the volume is empty
  int base_log2 = 3;           ///< of a base cell's side, in voxels; at least that of a brick
  GridBox box;                 ///< in voxels
  std::vector<std::uint32_t> entries;
  std::vector<MajorantBounds> bounds;
  float outside = 0;

  /// The largest of all, `outside` among them.
  float max_value() const;
  std::size_t bytes() const {
    return entries.capacity() * sizeof(std::uint32_t) + bounds.capacity() * sizeof(MajorantBounds);
  }
};

/// A grid that is bounded, times a factor that is not negative.
struct MajorantSource {
  const BrickGrid* grid;
  float factor = 1;
};

/// What is asked of bounds.
struct MajorantNeeds {
  /// Optical thickness of a voxel per unit of the volume: how often a ray meets what is not there where a bound is one
  /// too large, for each voxel that it passes. 0: one leaf to each base cell.
  float thickness = 0;
  bool minorants = true;  ///< else they are 0
  /// Most base cells along a side; a power of two.
  int max_side = 128;
};

/// Bounds on all channels of grids, for one way of looking them up: the largest and the smallest of all. The grids have
/// as many voxels in the same places.
///
/// Leaves are chosen by what they cost a ray: a step for each leaf that it enters, and a lookup for each collision that
/// the difference of the bounds makes it meet. Both go with its length, so that a leaf of side s and volume V costs in
/// proportion to
///     V (3 / (2 s) + kLookupCost thickness (majorant - minorant)),
/// 2 s / 3 being the mean length of chords of a cube; from the smallest leaves up, eight become one where that costs
/// less. The smallest have a side of two voxels, or an eighth of a base cell, so that bounds never take more than a
/// fifth of the bricks' memory.
///
/// Bounds are a little wider than need be, for the rounding of lookups. A place less than a rounding error from a
/// leaf's face may belong to the neighbour, so kernels must get along with values beyond the bounds there.
///
/// The box is where the grid has other values than its background, which is 0 outside; grids that are clamped, repeated
/// or mirrored have the box of their voxels, and `outside` bounds what goes on around it.
MajorantGrid make_majorant_grid(std::span<const MajorantSource> sources, GridVolumeDescription::Filter filter,
                                MajorantNeeds needs = {});
MajorantGrid make_majorant_grid(const BrickGrid& grid, GridVolumeDescription::Filter filter, MajorantNeeds needs = {});

/// The kernels' row; both grids as given to make_majorant_grid(). The result must not outlive `majorant`. Throws
/// SceneError if the transform is singular.
MajorantGridRow make_majorant_grid_row(const MajorantGrid& majorant, const BrickGrid& grid,
                                       const Transform& local_to_world, GridVolumeDescription::Filter filter);

}  // namespace sheaf
