// Microflakes of a description: matrices that are none are found here.
#pragma once

#include "scene/tables/brick_grid.h"

namespace sheaf {

/// The largest projected area of the flakes whose matrix is xx, yy, zz, xy, xz, yz: the root of its largest eigenvalue.
/// Throws SceneError unless the numbers are finite and no eigenvalue is negative, but for rounding.
float largest_flake_area(const std::array<float, 6>& matrix);

/// A grid of matrices.
struct FlakeGrids {
  BrickGrid diagonal, others;  ///< xx, yy, zz; xy, xz, yz
  float most = 0;              ///< bounds the projected area: between voxels a matrix is a mean of theirs
};

/// Reads a .vol file of six channels. Throws SceneError at `where` for others, or if a voxel is no such matrix.
FlakeGrids load_flakes(const GridVolumeDescription& description, const SourceLocation& where);

}  // namespace sheaf
