// Making majorant grids: which leaves there are to be.
#pragma once

#include "scene/tables/majorant_grid.h"

#include <span>

namespace sheaf {

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
  bool cuts = true;       ///< else no leaf is smaller than a base cell
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
/// less. The smallest have a side of an eighth of a base cell, of one voxel in grids of up to a thousand voxels along
/// each side; of more, where bounds would take more than half of the memory that the grid takes.
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
