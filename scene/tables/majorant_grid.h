// Bounds of a volume from above and below in cells of many sizes, for tracking that takes small steps only where the
// volume varies and matters.
//
// The volume is cut into base cells of a power of two voxels; a table of them says which leaf each lies in, or how
// finely it is cut: a leaf is a cube of 2^k voxels, aligned to its size, of many base cells, of one, or of a part.
#pragma once

#include "scene/tables/brick_grid.h"

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

}  // namespace sheaf
