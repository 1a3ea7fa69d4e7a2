// Builds majorant grids and chooses their leaves.
#pragma once

#include "scene/tables/majorant_grid.h"

#include <span>

namespace sheaf {

/// A grid to be bounded, times a factor >= 0.
struct MajorantSource {
  const BrickGrid* grid;
  float factor = 1;
};

/// Requirements on the bounds.
struct MajorantNeeds {
  /// Optical thickness of a voxel per unit of the volume: the expected number of null collisions per voxel if a
  /// majorant is too large by 1. 0: one leaf per base cell.
  float thickness = 0;
  bool minorants = true;  ///< false: minorants are 0
  bool cuts = true;       ///< false: no leaf is smaller than a base cell
  /// Maximum number of base cells along an axis; a power of two.
  int max_side = 128;
};

/// Builds majorants and minorants over all channels of one or more grids, for one interpolation filter. The grids must
/// have the same layout of voxels.
///
/// Leaves are chosen by their expected cost for a ray: one step per leaf entered, and one lookup per collision due to
/// the difference of the bounds. Both are proportional to the length of the ray in the leaf. The mean chord length of a
/// cube of side s is 2 s / 3, so a leaf of side s and volume V costs in proportion to
///     V (3 / (2 s) + kLookupCost thickness (majorant - minorant)).
/// Bottom-up, eight leaves are merged into one if that costs less. The smallest leaves have 1/8 of the side of a base
/// cell, which is one voxel in grids of up to about 1000 voxels per axis. They are larger if bounds would take more
/// than half of the memory of the grids.
///
/// Bounds are widened slightly for the rounding of lookups. A point within a rounding error of a leaf's face may belong
/// to the neighbor, so kernels must tolerate values beyond the bounds there.
///
/// The box encloses the values that differ from the background, which is 0 outside. For clamped, repeated or mirrored
/// grids it encloses the voxels, and `outside` bounds the values around it.
MajorantGrid make_majorant_grid(std::span<const MajorantSource> sources, GridFilter filter, MajorantNeeds needs = {});
MajorantGrid make_majorant_grid(const BrickGrid& grid, GridFilter filter, MajorantNeeds needs = {});

/// Makes the kernels' row; both grids as given to make_majorant_grid(). The result must not outlive `majorant`. Throws
/// SceneError if the transform is singular.
MajorantGridRow make_majorant_grid_row(const MajorantGrid& majorant, const BrickGrid& grid,
                                       const Transform& local_to_world, GridFilter filter);

}  // namespace sheaf
