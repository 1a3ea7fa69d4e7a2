// Volumes as stored in files: dense, or in sparse blocks of voxels.
#pragma once

#include "core/math/transform.h"

#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace sheaf {

/// Maximum number of voxels along an axis. Beyond it, floats resolve positions no finer than 1/128 of a voxel.
inline constexpr int kMaxGridSide = 1 << 16;

/// Sparse voxels in blocks of 8^3. All other voxels have the background value.
class VoxelBlocks {
 public:
  static constexpr int kSide = 8;                        ///< edge of a block, in voxels
  static constexpr int kVoxels = kSide * kSide * kSide;  ///< voxels per block
  struct Block {
    std::array<int, 3> position;  ///< position of the first voxel / 8
    int edge;                     ///< 1; constant blocks may represent a cube of edge^3 blocks
    bool is_constant;
    /// Index into values(): kVoxels * channels floats, x fastest; constant blocks: one voxel.
    std::size_t first_value;
  };

  /// `channels` 1 or 3.
  explicit VoxelBlocks(int channels, std::array<float, 3> background = {})
      : channels_(channels), background_(background) {}

  /// Adds a block filled with background, at a position not yet used. The returned values may be written until the next
  /// call.
  std::span<float> add(std::array<int, 3> position);
  /// Adds a cube of blocks of constant value (`channels` floats). None of them may exist yet.
  void add_constant(std::array<int, 3> position, std::span<const float> value, int edge = 1);

  int channels() const { return channels_; }
  const std::array<float, 3>& background() const { return background_; }
  const std::vector<Block>& blocks() const { return blocks_; }
  const std::vector<float>& values() const { return values_; }

 private:
  int channels_;
  std::array<float, 3> background_;
  std::vector<Block> blocks_;
  std::vector<float> values_;
};

/// Content of a sparse volume file.
struct SparseVolume {
  VoxelBlocks voxels{1};
  Transform grid_to_local;       ///< from index space, where voxel (i, j, k) lies at the point (i, j, k)
  std::size_t stored_bytes = 0;  ///< size of the grid in its file
};

/// Content of a dense volume file.
struct DenseVolume {
  int channels = 1;           ///< 1, 3 or 6
  std::array<int, 3> size{};  ///< voxels along each axis
  std::vector<float> values;  ///< x fastest, channels interleaved
  Transform grid_to_local;    ///< as in SparseVolume
  /// The outermost voxels are interpolated towards zero, and the volume ends half a voxel beyond them.
  bool ends_at_zero = false;
};

}  // namespace sheaf
