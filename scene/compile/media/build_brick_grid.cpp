// Builds brick grids from dense arrays and from blocks of voxels.
#include "scene/compile/media/build_brick_grid.h"

#include "core/io/error.h"

#include <algorithm>
#include <limits>
#include <map>
#include <string>

namespace sheaf {

namespace {

static_assert(kBrickSide == VoxelBlocks::kSide);

constexpr std::uint32_t kNoBlock = 0xffffffffu;
constexpr std::size_t kAnySize = static_cast<std::size_t>(-1);

int floor_div8(int i) { return i >> 3; }

std::string text_of(const std::array<int, 3>& size) { return fmt::format("{} x {} x {}", size[0], size[1], size[2]); }

/// Size in MB for messages.
std::string megabytes(std::size_t bytes) { return fmt::format("{} MB", (bytes + 999'999) / 1'000'000); }

[[noreturn]] void fail_memory(const BrickGrid& grid, std::size_t bytes, std::size_t max_bytes) {
  throw SceneError(
      fmt::format("a grid of {} voxels would take {} of memory or more (expected at most {} for a file of its size; "
                  "check for stray tiles, or voxels far from the others)",
                  text_of(grid.cells), megabytes(bytes), megabytes(max_bytes)));
}

/// Sets the size of the table of bricks for `cells`; all entries are 0.
void set_size(BrickGrid& grid, const std::array<int, 3>& cells, std::size_t max_bytes) {
  std::size_t count = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (cells[axis] < 1 || cells[axis] > kMaxGridSide) {
      throw SceneError(fmt::format("a grid of {} voxels (expected sides from 1 to {})", text_of(cells), kMaxGridSide));
    }
    grid.cells[axis] = cells[axis];
    grid.bricks[axis] = (cells[axis] + kBrickSide - 1) / kBrickSide;
    count *= static_cast<std::size_t>(grid.bricks[axis]);
  }
  if (count > kMaxBricks) throw SceneError(fmt::format("a grid of {} voxels is too large", text_of(cells)));
  if (count * sizeof(std::uint32_t) > max_bytes) fail_memory(grid, count * sizeof(std::uint32_t), max_bytes);
  grid.entries.assign(count, 0);
}

/// Stores bricks. Constant bricks are shared: one per value.
class BrickStore {
 public:
  /// Throws SceneError as soon as the grid takes more than `max_bytes`.
  BrickStore(BrickGrid& grid, std::size_t max_bytes)
      : grid_(grid),
        max_bytes_(max_bytes),
        channels_(static_cast<std::size_t>(grid.channels)),
        voxel_(channels_ == 1 ? 1 : kColorVoxel) {
    scratch_.assign(grid.brick_size(), 0.0f);
    grid.minimum = std::numeric_limits<float>::infinity();
    grid.maximum = -grid.minimum;
  }

  /// The voxel at (x, y, z) of the next brick to be stored.
  float* voxel(int x, int y, int z) {
    return scratch_.data() + static_cast<std::size_t>((z * kBrickStride + y) * kBrickStride + x) * voxel_;
  }

  /// Stores the brick whose voxels were set through voxel().
  std::uint32_t store() {
    bool is_constant = true;
    for (std::size_t i = voxel_; i < scratch_.size() && is_constant; ++i)
      is_constant = scratch_[i] == scratch_[i - voxel_];
    return is_constant ? store_constant(scratch_.data()) : append();
  }

  std::uint32_t store_constant(const float* value) {
    std::array<float, 3> key{};
    std::copy_n(value, channels_, key.begin());
    const auto found = constant_.find(key);
    if (found != constant_.end()) return found->second;
    for (std::size_t i = 0; i < scratch_.size(); i += voxel_) std::copy_n(key.data(), channels_, scratch_.data() + i);
    return constant_[key] = append();
  }

 private:
  std::uint32_t append() {
    for (std::size_t i = 0; i < scratch_.size(); i += voxel_) {
      for (std::size_t c = 0; c < channels_; ++c) {
        grid_.minimum = std::min(grid_.minimum, scratch_[i + c]);
        grid_.maximum = std::max(grid_.maximum, scratch_[i + c]);
      }
    }
    const std::size_t bytes =
        grid_.entries.size() * sizeof(std::uint32_t) + (grid_.values.size() + scratch_.size()) * sizeof(float);
    if (bytes > max_bytes_) fail_memory(grid_, bytes, max_bytes_);
    grid_.values.insert(grid_.values.end(), scratch_.begin(), scratch_.end());
    return count_++;
  }

  BrickGrid& grid_;
  std::size_t max_bytes_, channels_, voxel_;
  std::vector<float> scratch_;
  std::map<std::array<float, 3>, std::uint32_t> constant_;
  std::uint32_t count_ = 0;
};

/// Calls f(brick coordinates, entry) for every entry.
template <class F> void for_each_brick(BrickGrid& grid, F&& f) {
  std::size_t entry = 0;
  std::array<int, 3> b{};
  for (b[2] = 0; b[2] < grid.bricks[2]; ++b[2])
    for (b[1] = 0; b[1] < grid.bricks[1]; ++b[1])
      for (b[0] = 0; b[0] < grid.bricks[0]; ++b[0]) f(b, grid.entries[entry++]);
}

/// Maps positions to blocks, with the background in between.
class BlockTable {
 public:
  explicit BlockTable(const VoxelBlocks& blocks) : blocks_(blocks), channels_(blocks.channels()) { find_bounds(); }

  bool is_empty() const { return voxel_max_[0] < voxel_min_[0]; }
  const std::array<int, 3>& voxel_min() const { return voxel_min_; }
  const std::array<int, 3>& voxel_max() const { return voxel_max_; }

  /// Sets each entry of the grid to the index of the block at its position. The grid's layout must be set.
  void index(BrickGrid& grid) {
    first_ = {floor_div8(grid.first[0]), floor_div8(grid.first[1]), floor_div8(grid.first[2])};
    size_ = grid.bricks;
    table_ = grid.entries;
    std::fill(table_.begin(), table_.end(), kNoBlock);
    for (std::size_t i = 0; i < blocks_.blocks().size(); ++i) {
      const VoxelBlocks::Block& b = blocks_.blocks()[i];
      std::array<int, 3> begin{}, end{};  // blocks of background may lie outside
      for (std::size_t axis = 0; axis < 3; ++axis) {
        begin[axis] = std::max(b.position[axis] - first_[axis], 0);
        end[axis] = std::min(b.position[axis] - first_[axis] + b.edge, size_[axis]);
      }
      for (int z = begin[2]; z < end[2]; ++z)
        for (int y = begin[1]; y < end[1]; ++y)
          for (int x = begin[0]; x < end[0]; ++x) {
            std::uint32_t& entry = table_[offset({x, y, z})];
            if (entry != kNoBlock) throw SceneError("a block of voxels appears twice");
            entry = static_cast<std::uint32_t>(i);
          }
    }
  }

  /// Stores the voxels of a brick. Bricks must come in the order of their entries. An entry may be overwritten once its
  /// brick is stored: no brick reads voxels of blocks before its own position.
  std::uint32_t store_brick(const std::array<int, 3>& b, BrickStore& store) const {
    std::array<const VoxelBlocks::Block*, 8> corner{};
    for (unsigned c = 0; c < 8; ++c)
      corner[c] =
          block({b[0] + static_cast<int>(c & 1), b[1] + static_cast<int>(c >> 1 & 1), b[2] + static_cast<int>(c >> 2)});
    if (const float* const value = common_value(corner)) return store.store_constant(value);
    for (unsigned c = 0; c < 8; ++c) copy(corner[c], c, store);
    return store.store();
  }

 private:
  std::size_t offset(const std::array<int, 3>& at) const {
    return (static_cast<std::size_t>(at[2]) * static_cast<std::size_t>(size_[1]) + static_cast<std::size_t>(at[1])) *
               static_cast<std::size_t>(size_[0]) +
           static_cast<std::size_t>(at[0]);
  }

  const VoxelBlocks::Block* block(const std::array<int, 3>& at) const {
    // The grid ends with the last non-background voxel.
    if (at[0] >= size_[0] || at[1] >= size_[1] || at[2] >= size_[2]) return nullptr;
    const std::uint32_t entry = table_[offset(at)];
    return entry == kNoBlock ? nullptr : &blocks_.blocks()[entry];
  }

  /// The common value of constant, equal blocks; null if they differ.
  const float* common_value(const std::array<const VoxelBlocks::Block*, 8>& blocks) const {
    const float* common = nullptr;
    for (const VoxelBlocks::Block* const b : blocks) {
      if (b != nullptr && !b->is_constant) return nullptr;
      const float* const value = b == nullptr ? blocks_.background().data() : &blocks_.values()[b->first_value];
      if (common != nullptr && !std::equal(value, value + channels_, common)) return nullptr;
      common = value;
    }
    return common;
  }

  /// Copies the part of a brick that the block at corner `c` holds. Bit `axis` of c: 0 for voxels 0 to 7, 1 for voxel
  /// 8.
  void copy(const VoxelBlocks::Block* block, unsigned c, BrickStore& store) const {
    const auto begin = [&](unsigned axis) { return (c >> axis & 1u) != 0 ? kBrickSide : 0; };
    const auto end = [&](unsigned axis) { return (c >> axis & 1u) != 0 ? kBrickStride : kBrickSide; };
    const float* const source = block == nullptr ? blocks_.background().data() : &blocks_.values()[block->first_value];
    const bool is_constant = block == nullptr || block->is_constant;
    for (int z = begin(2); z < end(2); ++z)
      for (int y = begin(1); y < end(1); ++y)
        for (int x = begin(0); x < end(0); ++x) {
          const int i = is_constant ? 0 : ((z & 7) * 8 + (y & 7)) * 8 + (x & 7);
          std::copy_n(source + static_cast<std::ptrdiff_t>(i) * channels_, channels_, store.voxel(x, y, z));
        }
  }

  void find_bounds() {
    constexpr int kFarthest = 1 << 27;
    const float* const background = blocks_.background().data();
    for (const VoxelBlocks::Block& b : blocks_.blocks()) {
      for (const int p : b.position)
        if (p < -kFarthest || p >= kFarthest) throw SceneError("a voxel is too far from the origin");
      const float* const values = &blocks_.values()[b.first_value];
      if (b.is_constant && !std::equal(values, values + channels_, background)) {
        const int last = b.edge * kBrickSide - 1;
        extend(b, {0, 0, 0});
        extend(b, {last, last, last});
      }
      for (int i = 0; i < (b.is_constant ? 0 : VoxelBlocks::kVoxels); ++i) {
        const float* const value = values + static_cast<std::ptrdiff_t>(i) * channels_;
        if (!std::equal(value, value + channels_, background)) extend(b, {i & 7, i >> 3 & 7, i >> 6});
      }
    }
  }

  void extend(const VoxelBlocks::Block& b, const std::array<int, 3>& at) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const int v = b.position[axis] * kBrickSide + at[axis];
      voxel_min_[axis] = std::min(voxel_min_[axis], v);
      voxel_max_[axis] = std::max(voxel_max_[axis], v);
    }
  }

  static constexpr int kMax = std::numeric_limits<int>::max();
  const VoxelBlocks& blocks_;
  int channels_;
  std::array<int, 3> first_{}, size_{};
  std::array<int, 3> voxel_min_{kMax, kMax, kMax}, voxel_max_{-kMax, -kMax, -kMax};
  std::span<std::uint32_t> table_;  ///< the grid's entries
};

}  // namespace

BrickGrid make_dense_grid(int channels, std::array<int, 3> size, std::span<const float> values, GridBorder border) {
  BrickGrid grid;
  grid.channels = channels;
  grid.border = border;
  set_size(grid, size, kAnySize);
  // Check the number of values
  const auto stride_y = static_cast<std::size_t>(size[0]), stride_z = stride_y * static_cast<std::size_t>(size[1]);
  if (values.size() != stride_z * static_cast<std::size_t>(size[2]) * static_cast<std::size_t>(channels)) {
    throw SceneError(
        fmt::format("{} values for a grid of {} voxels with {} channels", values.size(), text_of(size), channels));
  }
  grid.voxel_max = {size[0] - 1, size[1] - 1, size[2] - 1};
  // Copy the voxels of each brick, with one layer of its neighbors
  const auto wrap = [&](int i, std::size_t axis) {
    return static_cast<std::size_t>(i < size[axis] ? i : border == GridBorder::kRepeat ? 0 : size[axis] - 1);
  };
  BrickStore store(grid, kAnySize);
  for_each_brick(grid, [&](const std::array<int, 3>& b, std::uint32_t& entry) {
    for (int z = 0; z < kBrickStride; ++z)
      for (int y = 0; y < kBrickStride; ++y) {
        const std::size_t row = wrap(b[2] * kBrickSide + z, 2) * stride_z + wrap(b[1] * kBrickSide + y, 1) * stride_y;
        for (int x = 0; x < kBrickStride; ++x) {
          const std::size_t i = (row + wrap(b[0] * kBrickSide + x, 0)) * static_cast<std::size_t>(channels);
          std::copy_n(values.data() + i, channels, store.voxel(x, y, z));
        }
      }
    entry = store.store();
  });
  return grid;
}

BrickGrid make_sparse_grid(const VoxelBlocks& blocks, std::size_t max_bytes) {
  BrickGrid grid;
  grid.channels = blocks.channels();
  grid.background = blocks.background();
  const auto used = grid.background.begin() + grid.channels;
  grid.minimum = *std::min_element(grid.background.begin(), used);
  grid.maximum = *std::max_element(grid.background.begin(), used);
  BlockTable table(blocks);
  if (table.is_empty()) return grid;
  grid.voxel_min = table.voxel_min();
  grid.voxel_max = table.voxel_max();
  std::array<int, 3> cells{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    // The cell below the first voxel has its upper corner at that voxel. Bricks are aligned to blocks.
    const int first = floor_div8(grid.voxel_min[axis] - 1), last = floor_div8(grid.voxel_max[axis]);
    grid.first[axis] = first * kBrickSide;
    cells[axis] = static_cast<int>(
        std::min<std::int64_t>((std::int64_t{last} - first + 1) * kBrickSide, std::numeric_limits<int>::max()));
  }
  set_size(grid, cells, max_bytes);
  table.index(grid);
  BrickStore store(grid, max_bytes);
  for_each_brick(grid, [&](const std::array<int, 3>& b, std::uint32_t& entry) { entry = table.store_brick(b, store); });
  grid.minimum = std::min(grid.minimum, *std::min_element(grid.background.begin(), used));
  grid.maximum = std::max(grid.maximum, *std::max_element(grid.background.begin(), used));
  return grid;
}

}  // namespace sheaf
