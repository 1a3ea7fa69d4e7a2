// Builds brick grids from the voxels of files.
#pragma once

#include "scene/description/voxels.h"
#include "scene/tables/brick_grid.h"

#include <array>
#include <cstddef>
#include <span>

namespace sheaf {

/// Maximum number of entries of the brick table.
inline constexpr std::size_t kMaxBricks = std::size_t{1} << 27;

/// Builds a grid from the voxels (0, 0, 0) to size - (1, 1, 1). `values` are x fastest, with interleaved channels (1 or
/// 3). Throws SceneError for a size outside [1, kMaxGridSide], for too many bricks, or for a wrong number of values.
/// `border` must not be kBackground.
BrickGrid make_dense_grid(int channels, std::array<int, 3> size, std::span<const float> values, GridBorder border);

/// Builds a grid with kBackground outside. Throws SceneError if the extent exceeds kMaxGridSide or kMaxBricks, for
/// duplicate blocks, for voxel coordinates beyond 2^30, or if the grid would take more than `max_bytes` of memory. The
/// last check matters because a few constant blocks can span a volume with a huge brick table.
BrickGrid make_sparse_grid(const VoxelBlocks& blocks, std::size_t max_bytes = static_cast<std::size_t>(-1));

}  // namespace sheaf
