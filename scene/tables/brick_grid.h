// Volumes in memory: a sparse grid of one or three floats per voxel, in bricks of 8^3 that share what is constant.
//
// Voxel (i, j, k) of index space has its value at the point (i, j, k). A brick stands for the 8^3 cells between voxels
// whose lowest corners it holds, and so stores 9^3 voxels: a trilinear lookup reads one entry of the table of bricks
// and one brick. Bricks of one value are stored once for each value.
#pragma once

#include "core/transform.h"
#include "scene/description/description.h"
#include "scene/description/voxels.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace sheaf {

/// What is outside of a grid.
enum class GridBorder : std::uint32_t {
  kBackground,  ///< one value, towards which the outermost voxels are interpolated
  kClamp,       ///< the nearest place of the grid
  kRepeat,      ///< the grid again
  kMirror,      ///< the grid and its mirror image in turn
};

/// Edge of a brick, in cells.
inline constexpr int kBrickSide = VoxelBlocks::kSide;
/// Edge of a brick, in voxels.
inline constexpr int kBrickStride = kBrickSide + 1;
/// Voxels of a brick, x fastest.
inline constexpr int kBrickVoxels = kBrickStride * kBrickStride * kBrickStride;
/// Floats of a voxel in a brick of three channels; the fourth is zero.
inline constexpr int kColorVoxel = 4;

/// What kernels read of a grid: two cache lines. Pointers lead into a BrickGrid, which must outlive the row.
struct alignas(64) BrickGridRow {
  /// Columns of the 3x4 matrix from world space to the grid, four floats each, the last of which is zero. For lookups
  /// of the nearest voxel half a voxel is added, so that voxel i is all of [i, i + 1).
  float world_to_grid[16] = {};
  const std::uint32_t* entries = nullptr;    ///< brick of each 8^3 cells, x fastest
  const float* values = nullptr;             ///< bricks of kBrickVoxels voxels of one float or kColorVoxel floats
  std::uint32_t cells[3] = {};               ///< lookups stay in [0, cells); without kBackground the number of voxels
  std::uint32_t stride_y = 0, stride_z = 0;  ///< of `entries`
  std::uint32_t channels = 1;                ///< 1 or 3
  GridBorder border = GridBorder::kBackground;
  bool nearest = false;  ///< the nearest voxel's value; else trilinear
  float background[3] = {};
};
static_assert(sizeof(BrickGridRow) == 128);

/// What kernels see of all grids.
struct BrickGridView {
  const BrickGridRow* rows = nullptr;
};

/// A box with sides along the axes. Empty if a minimum exceeds its maximum.
struct GridBox {
  Vec3f min{}, max{};
};

/// Owns a grid.
struct BrickGrid {
  int channels = 1;  ///< 1 or 3
  GridBorder border = GridBorder::kBackground;
  std::array<float, 3> background{};         ///< as many as channels; only for kBackground
  std::array<int, 3> first{};                ///< voxel where the first brick begins
  std::array<int, 3> voxel_min{};            ///< the first voxel that is not just background
  std::array<int, 3> voxel_max{-1, -1, -1};  ///< the last such voxel
  std::array<int, 3> cells{};                ///< BrickGridRow::cells
  std::array<int, 3> bricks{};               ///< size of the table of bricks
  std::vector<std::uint32_t> entries;
  std::vector<float> values;
  /// From index space to the space that GridVolumeDescription::to_world maps to world space.
  Transform grid_to_local;
  float minimum = 0, maximum = 0;  ///< of all channels; including the background, if that is what surrounds the grid

  /// Whether there is nothing but background.
  bool is_empty() const { return voxel_max[0] < voxel_min[0]; }
  /// An upper bound on all interpolated values of all channels.
  float max_value() const { return maximum; }
  /// A lower bound on the same.
  float min_value() const { return minimum; }
  /// Memory held.
  std::size_t bytes() const { return entries.capacity() * sizeof(std::uint32_t) + values.capacity() * sizeof(float); }
  /// Floats per brick.
  std::size_t brick_size() const { return std::size_t{kBrickVoxels} * (channels == 1 ? 1 : kColorVoxel); }
  /// Bounds in local space of the cubes of side 1 around the voxels; Mitsuba's .vol: the unit cube or the file's box.
  /// Empty for a grid that is.
  GridBox voxel_box() const;
  /// Bounds in local space of all places with another value than the background; without background voxel_box().
  GridBox local_box(GridVolumeDescription::Filter filter = GridVolumeDescription::Filter::kTrilinear) const;
};

/// Largest number of bricks, stored or not.
inline constexpr std::size_t kMaxBricks = std::size_t{1} << 27;

/// A grid of all voxels of (0, 0, 0) to size - (1, 1, 1); `values` are x fastest, channels (1 or 3) next to each other.
/// Throws SceneError for a size that is not from 1 to kMaxGridSide, for too many bricks, or if the number of values
/// does not fit. `border` is not kBackground.
BrickGrid make_dense_grid(int channels, std::array<int, 3> size, std::span<const float> values, GridBorder border);

/// A grid with kBackground outside. Throws SceneError if blocks lie too far from each other for kMaxGridSide or
/// kMaxBricks, if one is there twice, if a coordinate of a voxel exceeds 2^30, or if it would take more than
/// `most_bytes` of memory: a few constant blocks may span a volume whose table of bricks is beyond all measure.
BrickGrid make_sparse_grid(const VoxelBlocks& blocks, std::size_t most_bytes = static_cast<std::size_t>(-1));

/// The kernels' row of a grid, which must outlive it. Throws SceneError if the transform is singular.
BrickGridRow make_brick_grid_row(const BrickGrid& grid, const Transform& local_to_world,
                                 GridVolumeDescription::Filter filter);

/// Bounds in the space that BrickGridRow::world_to_grid leads to of all that local_box() bounds.
GridBox row_box(const BrickGrid& grid, GridVolumeDescription::Filter filter);

}  // namespace sheaf
