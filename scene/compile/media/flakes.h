// Loads the SGGX matrices of microflakes (Heitz et al. 2015) and checks that they are valid.
#pragma once

#include "core/io/error.h"
#include "scene/description/grid_volume.h"
#include "scene/tables/brick_grid.h"

namespace sheaf {

/// Maximum projected area of flakes with the matrix xx, yy, zz, xy, xz, yz: the square root of its largest eigenvalue.
/// Throws SceneError if an entry is not finite or an eigenvalue is negative by more than rounding.
float largest_flake_area(const std::array<float, 6>& matrix);

/// A grid of matrices.
struct FlakeGrids {
  BrickGrid diagonal, others;  ///< xx, yy, zz; xy, xz, yz
  float largest = 0;           ///< upper bound on the projected area; interpolated matrices do not exceed it
};

/// Reads a .vol file of six channels. Throws SceneError at `where` for other files and for invalid matrices.
FlakeGrids load_flakes(const GridVolumeDescription& description, const SourceLocation& where);

}  // namespace sheaf
