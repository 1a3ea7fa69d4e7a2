// Volumes as files hold them: all voxels of a box, or blocks of them.
#pragma once

#include "core/transform.h"

#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace sheaf {

/// Largest number of voxels in a row: beyond, floats leave less than 1/128 of a voxel to positions.
inline constexpr int kMaxGridSide = 1 << 16;

/// Voxels in blocks of 8^3. All else is background.
class VoxelBlocks {
 public:
  static constexpr int kSide = 8;                        ///< of a block, in voxels
  static constexpr int kVoxels = kSide * kSide * kSide;  ///< of a block
  struct Block {
    std::array<int, 3> position;  ///< of the first voxel, over 8
    int edge;                     ///< 1; constant ones may stand for a cube of so many blocks along each side
    bool is_constant;
    std::size_t first_value;  ///< into values(): kVoxels times channels floats, x fastest; constant: of one voxel
  };

  /// `channels` 1 or 3.
  explicit VoxelBlocks(int channels, std::array<float, 3> background = {})
      : channels_(channels), background_(background) {}

  /// Adds a block of background, which may not be there yet. The values may be changed until the next call.
  std::span<float> add(std::array<int, 3> position);
  /// Adds a cube of blocks of one value, `channels` floats. None of them may be there yet.
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

/// What a sparse file holds.
struct SparseVolume {
  VoxelBlocks voxels{1};
  Transform grid_to_local;       ///< from index space, where voxel (i, j, k) is at the point (i, j, k)
  std::size_t stored_bytes = 0;  ///< that the grid takes in its file
};

/// What a dense file holds.
struct DenseVolume {
  int channels = 1;           ///< 1, 3 or 6
  std::array<int, 3> size{};  ///< voxels along each axis
  std::vector<float> values;  ///< x fastest, channels next to each other
  Transform grid_to_local;    ///< as SparseVolume's
  /// Outermost voxels are interpolated towards zero, and half a voxel beyond them the volume ends.
  bool ends_at_zero = false;
};

}  // namespace sheaf
