// Bounds of a volume from above and below in cells of many sizes, for tracking that takes small steps only where the
// volume varies and matters.
//
// The volume is cut into base cells of a power of two voxels; a table of them says which leaf each lies in, or how
// finely it is cut: a leaf is a cube of 2^k voxels, aligned to its size, of many base cells, of one, or of a part.
#pragma once

#include "scene/tables/brick_grid.h"

namespace sheaf {

/// Bounds on a volume's values in a leaf, neither of them negative. Each is a float without the 16 lowest bits, which
/// moves it by less than a hundredth.
struct MajorantBounds {
  std::uint32_t bits = 0;  ///< the majorant's in the upper half, the minorant's in the lower

  /// The narrowest that hold two values. A majorant close to the largest float becomes infinite.
  static MajorantBounds around(float minorant, float majorant) {
    const std::uint32_t up = float_bits(majorant) + 0xffffu;
    return {(up & 0xffff0000u) | float_bits(minorant) >> 16};
  }
  float majorant() const { return bits_float(bits & 0xffff0000u); }
  float minorant() const { return bits_float(bits << 16); }
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
  float outside = 0;                       ///< zero: there is nothing outside
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
