// Sparse volume grids with one or three floats per voxel, stored as bricks of 8^3 cells that share constant data.
//
// Voxel (i, j, k) of index space has its value at the point (i, j, k). A brick covers the 8^3 cells whose lowest
// corners are its voxels, and so stores 9^3 voxels. A trilinear lookup reads one entry of the brick table and one
// brick. Constant bricks are stored once per value.
#pragma once

#include "core/math/bounds.h"
#include "core/math/transform.h"
#include "scene/tables/interpolation.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace sheaf {

/// Values outside of a grid.
enum class GridBorder : std::uint32_t {
  kBackground,  ///< a constant, towards which the outermost voxels are interpolated
  kClamp,       ///< the nearest value on the boundary
  kRepeat,      ///< periodic repetition
  kMirror,      ///< repetition with every second copy mirrored
};

/// Edge of a brick in cells.
inline constexpr int kBrickSide = 8;
/// Edge of a brick in voxels.
inline constexpr int kBrickStride = kBrickSide + 1;
/// Voxels per brick, x fastest.
inline constexpr int kBrickVoxels = kBrickStride * kBrickStride * kBrickStride;
/// Floats per voxel in bricks of three channels; the fourth is zero.
inline constexpr int kColorVoxel = 4;

/// A grid's row for kernels: two cache lines. Pointers refer to a BrickGrid, which must outlive the row.
struct alignas(64) BrickGridRow {
  /// Columns of the 3x4 matrix from world space to grid space, four floats each with a zero last. For nearest lookups,
  /// half a voxel is added, so that voxel i covers [i, i + 1).
  float world_to_grid[16] = {};
  const std::uint32_t* entries = nullptr;  ///< index of the brick for each 8^3 cells, x fastest
  const float* values = nullptr;           ///< bricks of kBrickVoxels voxels, each one float or kColorVoxel floats
  /// Lookups are limited to [0, cells). Without kBackground this is the number of voxels.
  std::uint32_t cells[3] = {};
  std::uint32_t stride_y = 0, stride_z = 0;  ///< strides of `entries`
  std::uint32_t channels = 1;                ///< 1 or 3
  GridBorder border = GridBorder::kBackground;
  bool nearest = false;  ///< the nearest voxel's value; else trilinear
  float background[3] = {};
};
static_assert(sizeof(BrickGridRow) == 128);

/// All grids of a scene, for kernels.
struct BrickGridView {
  const BrickGridRow* rows = nullptr;
};

/// Owns a grid.
struct BrickGrid {
  int channels = 1;  ///< 1 or 3
  GridBorder border = GridBorder::kBackground;
  std::array<float, 3> background{};         ///< `channels` values; only for kBackground
  std::array<int, 3> first{};                ///< voxel at which the first brick begins
  std::array<int, 3> voxel_min{};            ///< first voxel that differs from the background
  std::array<int, 3> voxel_max{-1, -1, -1};  ///< last voxel that differs from the background
  std::array<int, 3> cells{};                ///< BrickGridRow::cells
  std::array<int, 3> bricks{};               ///< size of the table of bricks
  std::vector<std::uint32_t> entries;
  std::vector<float> values;
  /// From index space to the space that GridVolumeDescription::to_world maps to world space.
  Transform grid_to_local;
  /// Over all channels; includes the background if that surrounds the grid.
  float minimum = 0, maximum = 0;

  /// Whether the grid is all background.
  bool is_empty() const { return voxel_max[0] < voxel_min[0]; }
  /// Upper bound on the interpolated values of all channels.
  float max_value() const { return maximum; }
  /// Memory in bytes.
  std::size_t bytes() const { return entries.capacity() * sizeof(std::uint32_t) + values.capacity() * sizeof(float); }
  /// Floats per brick.
  std::size_t brick_size() const { return std::size_t{kBrickVoxels} * (channels == 1 ? 1 : kColorVoxel); }
  /// Bounding box in local space of the unit cubes around the voxels. For Mitsuba's .vol files this is the unit cube or
  /// the file's box. Empty for an empty grid.
  Bounds3f voxel_box() const;
};

/// Makes the kernels' row of a grid, which must outlive it. Throws SceneError if the transform is singular.
BrickGridRow make_brick_grid_row(const BrickGrid& grid, const Transform& local_to_world, GridFilter filter);

/// Bounding box, in the target space of BrickGridRow::world_to_grid, of all points whose value differs from the
/// background; without background, of the voxels.
Bounds3f row_box(const BrickGrid& grid, GridFilter filter);

}  // namespace sheaf
