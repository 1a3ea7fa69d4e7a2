// Majorants and minorants of a volume in cells of many sizes. Tracking takes small steps only where the volume varies
// and is dense.
//
// The volume is divided into base cells with a power of two voxels per side. A table gives the leaf that contains each
// base cell, or the subdivision of the cell. A leaf is an aligned cube of 2^k voxels per side: many base cells, one, or
// a part of one.
#pragma once

#include "scene/tables/brick_grid.h"

namespace sheaf {

/// Bounds on a volume's values in a leaf, not negative. Each is a float without the lowest 16 bits, which changes it by
/// less than 1%.
struct MajorantBounds {
  std::uint32_t bits = 0;  ///< majorant in the upper half, minorant in the lower half

  /// The tightest bounds that contain two values. A majorant close to the maximum float becomes infinite.
  static MajorantBounds around(float minorant, float majorant) {
    const std::uint32_t up = float_bits(majorant) + 0xffffu;
    return {(up & 0xffff0000u) | float_bits(minorant) >> 16};
  }
  float majorant() const { return bits_float(bits & 0xffff0000u); }
  float minorant() const { return bits_float(bits << 16); }
};

/// An entry of the table of base cells. The low bits hold the base-2 logarithm of the leaf's side in voxels, the other
/// bits the index of its first leaf's bounds. The leaves of a subdivided base cell are stored x fastest.
inline constexpr int kMajorantSideBits = 5;

/// A majorant grid's row for kernels, in the coordinates of BrickGridRow::world_to_grid. Base cell (i, j, k) starts at
/// 2^base_log2 times (i, j, k). The outermost cells extend to the faces of the box.
struct alignas(64) MajorantGridRow {
  float world_to_grid[16] = {};            ///< columns of the 3x4 matrix, four floats each with a zero last
  float box_min[3] = {}, box_max[3] = {};  ///< in voxels; beyond it, `outside` is the majorant
  const std::uint32_t* entries = nullptr;  ///< one per base cell, x fastest
  const MajorantBounds* bounds = nullptr;  ///< of the leaves
  std::uint32_t cells[3] = {};             ///< number of base cells
  std::uint32_t base_log2 = 0;             ///< log2 of a base cell's side in voxels
  float outside = 0;                       ///< zero: empty outside
};
static_assert(sizeof(MajorantGridRow) == 128);

/// Owns the majorants and minorants of a volume.
struct MajorantGrid {
  std::array<int, 3> cells{};  ///< number of base cells; all 0: the volume is empty
  int base_log2 = 3;           ///< log2 of a base cell's side in voxels; at least that of a brick
  Bounds3f box;                ///< in voxels
  std::vector<std::uint32_t> entries;
  std::vector<MajorantBounds> bounds;
  float outside = 0;

  /// Maximum of all majorants, including `outside`.
  float max_value() const;
  /// Estimate of the mean of the volume's values in the box, weighted by the values: the mean that particles see.
  float mean_value() const;
  std::size_t bytes() const {
    return entries.capacity() * sizeof(std::uint32_t) + bounds.capacity() * sizeof(MajorantBounds);
  }
};

}  // namespace sheaf
