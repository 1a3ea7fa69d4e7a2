#include "scene/compile/media/make_majorants.h"

#include "core/io/error.h"

#include <algorithm>

namespace sheaf {

namespace {

/// Widening for the rounding of lookups, which sum up to eight products with rounded weights.
constexpr float kBoundMargin = 1.0f + 4e-6f;
/// Cost of a collision with its lookup, in steps between leaves.
constexpr float kLookupCost = 4.0f;
constexpr int kBrickLog2 = 3;
static_assert(1 << kBrickLog2 == kBrickSide);
/// Log2 of the maximum number of leaves along each side of a base cell.
constexpr int kMaxCut = 3;
/// Log2 of the maximum side of a leaf in base cells.
constexpr int kMaxBaseCellsLog2 = 4;

/// Minimum and maximum of some values.
struct ValueRange {
  float low = kInfinity, high = -kInfinity;

  void add(float value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
  void add(const ValueRange& other) {
    low = std::min(low, other.low);
    high = std::max(high, other.high);
  }
};

MajorantBounds bounds_of(const ValueRange& range, bool minorants) {
  const float largest = std::max(range.high, 0.0f), smallest = minorants ? std::max(range.low, 0.0f) : 0.0f;
  return MajorantBounds::around(smallest * (2.0f - kBoundMargin), largest * kBoundMargin);
}

std::size_t at(const std::array<int, 3>& size, int x, int y, int z) {
  return (static_cast<std::size_t>(z) * static_cast<std::size_t>(size[1]) + static_cast<std::size_t>(y)) *
             static_cast<std::size_t>(size[0]) +
         static_cast<std::size_t>(x);
}

/// Ranges of the cubes of side 2^log2 voxels in a base cell, x fastest.
struct Level {
  int log2 = 0, side = 0;  ///< side: cubes along an edge of the base cell
  std::vector<ValueRange> ranges;

  ValueRange& range(int x, int y, int z) { return ranges[static_cast<std::size_t>((z * side + y) * side + x)]; }
};

/// Ranges of all bricks of a grid.
std::vector<ValueRange> brick_ranges(const MajorantSource& source) {
  const BrickGrid& grid = *source.grid;
  const std::size_t size = grid.brick_size(), voxel = grid.channels == 1 ? 1 : kColorVoxel;
  std::vector<ValueRange> ranges(grid.values.size() / size);
  for (std::size_t brick = 0; brick < ranges.size(); ++brick)
    for (std::size_t i = 0; i < size; i += voxel)
      for (std::size_t c = 0; c < static_cast<std::size_t>(grid.channels); ++c)
        ranges[brick].add(grid.values[brick * size + i + c] * source.factor);
  return ranges;
}

/// Ranges of the grids' values in the cubes of a base cell, from the finest cubes to the base cell itself.
class BaseCellRanges {
 public:
  BaseCellRanges(std::span<const MajorantSource> sources, GridFilter filter, int base_log2, int max_cut)
      : sources_(sources),
        layout_(*sources.front().grid),
        voxels_beyond_(filter == GridFilter::kNearest ? 0 : 1),
        base_log2_(base_log2) {
    for (const MajorantSource& source : sources) brick_ranges_.push_back(brick_ranges(source));
    for (int cut = max_cut; cut >= 0; --cut) {
      const int side = 1 << cut;
      levels_.push_back({base_log2 - cut, side, std::vector<ValueRange>(static_cast<std::size_t>(side * side * side))});
    }
  }

  /// From the finest level to the base cell itself. Valid from the level on with which fill() was called.
  std::span<const Level> levels() const { return levels_; }

  /// Selects a base cell and returns its range.
  ValueRange look(const std::array<int, 3>& cell) {
    const int bricks = 1 << (base_log2_ - kBrickLog2);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      first_[axis] = cell[axis] * bricks;
      last_[axis] = std::min(first_[axis] + bricks, layout_.bricks[axis]);
    }
    return range_of_bricks(wraps());
  }

  /// Computes the ranges of the selected base cell's cubes, from levels()[level] to the coarsest.
  void fill(std::size_t level) {
    Level& finest = levels_[level];
    std::fill(finest.ranges.begin(), finest.ranges.end(), ValueRange());
    for (std::size_t i = 0; i < sources_.size(); ++i)
      for (int z = first_[2]; z < last_[2]; ++z)
        for (int y = first_[1]; y < last_[1]; ++y)
          for (int x = first_[0]; x < last_[0]; ++x) add_brick(i, {x, y, z}, finest);
    add_repeated(finest);
    // Cubes beyond the last brick are outside the box.
    for (ValueRange& range : finest.ranges)
      if (range.high < range.low) range = {0.0f, 0.0f};
    for (std::size_t i = level + 1; i < levels_.size(); ++i) halve(levels_[i - 1], levels_[i]);
  }

 private:
  std::size_t brick(std::size_t source, int x, int y, int z) const {
    return sources_[source].grid->entries[at(layout_.bricks, x, y, z)];
  }

  /// Bit `axis` is set if a repeated grid interpolates with its last voxel before the base cell's first voxel.
  unsigned wraps() const {
    unsigned bits = 0;
    for (unsigned axis = 0; axis < 3; ++axis)
      if (layout_.border == GridBorder::kRepeat && first_[axis] == 0) bits |= 1u << axis;
    return bits;
  }

  /// Range of the base cell's bricks, and of the bricks that wrap around along the axes of `wrapped`.
  ValueRange range_of_bricks(unsigned wrapped) const {
    ValueRange range;
    const auto each = [&](std::size_t axis, auto&& f) {
      for (int i = first_[axis]; i < last_[axis]; ++i) f(i);
      if ((wrapped >> axis & 1u) != 0) f(layout_.bricks[axis] - 1);
    };
    for (std::size_t i = 0; i < sources_.size(); ++i)
      each(2, [&](int z) {
        each(1, [&](int y) { each(0, [&](int x) { range.add(brick_ranges_[i][brick(i, x, y, z)]); }); });
      });
    return range;
  }

  void add_repeated(Level& finest) const {
    const unsigned wrapped = wraps();
    if (wrapped == 0) return;
    for (int z = 0; z < finest.side; ++z)
      for (int y = 0; y < finest.side; ++y)
        for (int x = 0; x < finest.side; ++x) {
          const unsigned here = wrapped & ((x == 0 ? 1u : 0u) | (y == 0 ? 2u : 0u) | (z == 0 ? 4u : 0u));
          if (here != 0) finest.range(x, y, z).add(range_of_bricks(here));
        }
  }

  static void halve(const Level& from, Level& to) {
    std::fill(to.ranges.begin(), to.ranges.end(), ValueRange());
    std::size_t i = 0;
    for (int z = 0; z < from.side; ++z)
      for (int y = 0; y < from.side; ++y)
        for (int x = 0; x < from.side; ++x) to.range(x >> 1, y >> 1, z >> 1).add(from.ranges[i++]);
  }

  /// Adds a brick's voxels to the cubes whose interpolation reads them.
  void add_brick(std::size_t source, const std::array<int, 3>& b, Level& finest) const {
    const std::size_t index = brick(source, b[0], b[1], b[2]);
    const ValueRange& whole = brick_ranges_[source][index];
    const int log2 = std::min(finest.log2, kBrickLog2), side = 1 << log2, cubes = kBrickSide >> log2;
    const int shift = finest.log2 - log2;
    for (int z = 0; z < cubes; ++z)
      for (int y = 0; y < cubes; ++y)
        for (int x = 0; x < cubes; ++x) {
          ValueRange& range =
              finest.range(((b[0] - first_[0]) * cubes + x) >> shift, ((b[1] - first_[1]) * cubes + y) >> shift,
                           ((b[2] - first_[2]) * cubes + z) >> shift);
          const bool is_whole = cubes == 1 || whole.low == whole.high;
          range.add(is_whole ? whole : cube_range(sources_[source], index, {x * side, y * side, z * side}, side));
        }
  }

  /// Range of the brick's voxels that lookups in the `side`^3 cells from `first` read.
  ValueRange cube_range(const MajorantSource& source, std::size_t brick, const std::array<int, 3>& first,
                        int side) const {
    const BrickGrid& grid = *source.grid;
    const float* const values = &grid.values[brick * grid.brick_size()];
    const int voxel = grid.channels == 1 ? 1 : kColorVoxel;
    const int count = side + voxels_beyond_;
    ValueRange range;
    for (int z = first[2]; z < first[2] + count; ++z)
      for (int y = first[1]; y < first[1] + count; ++y) {
        const float* const row = values + ((z * kBrickStride + y) * kBrickStride + first[0]) * voxel;
        for (int x = 0; x < count; ++x)
          for (int c = 0; c < grid.channels; ++c) range.add(row[x * voxel + c] * source.factor);
      }
    return range;
  }

  std::span<const MajorantSource> sources_;
  const BrickGrid& layout_;
  int voxels_beyond_;  ///< voxels beyond a cell that interpolation in it reads
  int base_log2_;
  std::vector<std::vector<ValueRange>> brick_ranges_;  ///< per source
  std::vector<Level> levels_;
  std::array<int, 3> first_{}, last_{};  ///< bricks of the base cell
};

/// Chooses leaves by cost.
class Builder {
 public:
  Builder(std::span<const MajorantSource> sources, GridFilter filter, MajorantNeeds needs, int max_cut,
          MajorantGrid& out)
      : needs_(needs), ranges_(sources, filter, out.base_log2, is_uniform() || !needs.cuts ? 0 : max_cut), out_(out) {
    out.entries.assign(at(out.cells, 0, 0, out.cells[2]), 0);
    out.bounds.assign(1, {});  // bounds of empty leaves
  }

  void run() {
    const int cube = is_uniform() ? 0 : kMaxBaseCellsLog2, step = 1 << cube;
    for (int z = 0; z < out_.cells[2]; z += step)
      for (int y = 0; y < out_.cells[1]; y += step)
        for (int x = 0; x < out_.cells[0]; x += step) add_cube({x, y, z}, cube);
    out_.bounds.shrink_to_fit();
  }

 private:
  /// A cube whose leaves have been chosen; cost and volume are relative to that of the whole cube.
  struct Node {
    ValueRange range;
    double cost = 0, volume = 0;
  };

  bool is_uniform() const { return !(needs_.thickness > 0.0f); }

  /// Adds a cube with 2^log2 base cells per side, clipped to the grid.
  Node add_cube(const std::array<int, 3>& first, int log2) {
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (first[axis] >= out_.cells[axis]) return {};
    if (log2 == 0) return add_base_cell(first);
    const std::size_t mark = out_.bounds.size();
    const int half = 1 << (log2 - 1);
    Node node;
    for (int child = 0; child < 8; ++child) {
      const Node found =
          add_cube({first[0] + (child & 1) * half, first[1] + (child >> 1 & 1) * half, first[2] + (child >> 2) * half},
                   log2 - 1);
      node.range.add(found.range);
      node.cost += 0.125 * found.cost;
      node.volume += 0.125 * found.volume;
    }
    const double as_leaf = node.volume * leaf_cost(node.range, out_.base_log2 + log2);
    if (as_leaf > node.cost) return node;
    out_.bounds.resize(mark);
    set_leaf(first, log2, node.range);
    return {node.range, as_leaf, node.volume};
  }

  Node add_base_cell(const std::array<int, 3>& cell) {
    const ValueRange range = ranges_.look(cell);
    double cost = leaf_cost(range, out_.base_log2);
    const Level* best = nullptr;
    if (!is_uniform() && range.low < range.high) {
      const std::size_t first = first_level(range);
      ranges_.fill(first);
      for (const Level& level : ranges_.levels().subspan(first)) {
        double sum = 0;
        for (const ValueRange& part : level.ranges) sum += leaf_cost(part, level.log2);
        sum /= static_cast<double>(level.ranges.size());
        if (sum < cost) cost = sum, best = &level;
      }
    }
    if (best == nullptr) {
      set_leaf(cell, 0, range);
    } else {
      out_.entries[at(out_.cells, cell[0], cell[1], cell[2])] = make_entry(out_.bounds.size(), best->log2);
      for (const ValueRange& part : best->ranges) out_.bounds.push_back(bounds_of(part, needs_.minorants));
    }
    return {range, cost, 1.0};
  }

  /// The finest level that may be worth its cost: halving the side doubles the cost of steps, and saves at most the
  /// whole cost of the bounds' difference.
  std::size_t first_level(const ValueRange& range) const {
    const auto levels = ranges_.levels();
    const double max_cost = leaf_cost(range, 30);
    std::size_t first = 0;
    while (first + 1 < levels.size() && 0.75 / static_cast<double>(1 << levels[first].log2) > max_cost) ++first;
    return first;
  }

  /// Cost of a leaf per volume.
  double leaf_cost(const ValueRange& range, int log2) const {
    const MajorantBounds b = bounds_of(range, needs_.minorants);
    return 1.5 / static_cast<double>(1 << log2) +
           static_cast<double>(kLookupCost * needs_.thickness) * static_cast<double>(b.majorant() - b.minorant());
  }

  /// Makes a cube of base cells one leaf.
  void set_leaf(const std::array<int, 3>& first, int log2, const ValueRange& range) {
    const MajorantBounds b = bounds_of(range, needs_.minorants);
    std::size_t index = 0;
    if (b.bits != 0) {
      index = out_.bounds.size();
      out_.bounds.push_back(b);
    }
    const std::uint32_t entry = make_entry(index, out_.base_log2 + log2);
    std::array<int, 3> last{};
    for (std::size_t axis = 0; axis < 3; ++axis) last[axis] = std::min(first[axis] + (1 << log2), out_.cells[axis]);
    for (int z = first[2]; z < last[2]; ++z)
      for (int y = first[1]; y < last[1]; ++y)
        for (int x = first[0]; x < last[0]; ++x) out_.entries[at(out_.cells, x, y, z)] = entry;
  }

  static std::uint32_t make_entry(std::size_t bounds, int log2) {
    if (bounds >> (32 - kMajorantSideBits) != 0) throw SceneError("a grid has too many voxels for its bounds");
    return static_cast<std::uint32_t>(bounds << kMajorantSideBits) | static_cast<std::uint32_t>(log2);
  }

  MajorantNeeds needs_;
  BaseCellRanges ranges_;
  MajorantGrid& out_;
};

}  // namespace

float MajorantGrid::max_value() const {
  float largest = outside;
  for (const MajorantBounds& b : bounds) largest = std::max(largest, b.majorant());
  return largest;
}

float MajorantGrid::mean_value() const {
  if (entries.empty()) return outside;
  double sum = 0, sum_of_squares = 0;
  for (const std::uint32_t entry : entries) {
    const int below = base_log2 - static_cast<int>(entry & ((1u << kMajorantSideBits) - 1u));
    const std::size_t leaves = below > 0 ? std::size_t{1} << 3 * below : 1;
    for (std::size_t i = 0; i < leaves; ++i) {
      const MajorantBounds b = bounds[(entry >> kMajorantSideBits) + i];
      const double value = 0.5 * (double{b.minorant()} + double{b.majorant()});
      sum += value / static_cast<double>(leaves);
      sum_of_squares += value * value / static_cast<double>(leaves);
    }
  }
  return sum > 0 ? static_cast<float>(sum_of_squares / sum) : 0.0f;
}

MajorantGrid make_majorant_grid(std::span<const MajorantSource> sources, GridFilter filter, MajorantNeeds needs) {
  MajorantGrid result;
  // Bound the values outside
  ValueRange outside;
  for (const MajorantSource& source : sources) {
    const BrickGrid& grid = *source.grid;
    if (grid.border != GridBorder::kBackground)
      outside.add(grid.maximum * source.factor);
    else
      for (std::size_t c = 0; c < static_cast<std::size_t>(grid.channels); ++c)
        outside.add(grid.background[c] * source.factor);
  }
  result.outside = std::max(outside.high, 0.0f) * kBoundMargin;
  const BrickGrid& grid = *sources.front().grid;
  if (grid.is_empty()) return result;
  result.box = row_box(grid, filter);
  // Choose the size of the base cells
  const int longest = *std::max_element(grid.bricks.begin(), grid.bricks.end());
  while ((longest - 1) >> (result.base_log2 - kBrickLog2) >= needs.max_side) ++result.base_log2;
  for (std::size_t axis = 0; axis < 3; ++axis)
    result.cells[axis] = ((grid.bricks[axis] - 1) >> (result.base_log2 - kBrickLog2)) + 1;
  // Build, with fewer subdivisions if the result is too large
  std::size_t max_bytes = 1u << 16;
  for (const MajorantSource& source : sources) max_bytes = std::max(max_bytes, source.grid->bytes() / 2);
  for (int max_cut = kMaxCut; max_cut == kMaxCut || (max_cut > 0 && result.bytes() > max_bytes); --max_cut)
    Builder(sources, filter, needs, max_cut, result).run();
  return result;
}

MajorantGrid make_majorant_grid(const BrickGrid& grid, GridFilter filter, MajorantNeeds needs) {
  const MajorantSource source{&grid, 1.0f};
  return make_majorant_grid({&source, 1}, filter, needs);
}

MajorantGridRow make_majorant_grid_row(const MajorantGrid& majorant, const BrickGrid& grid,
                                       const Transform& local_to_world, GridFilter filter) {
  MajorantGridRow row;
  const BrickGridRow lookup = make_brick_grid_row(grid, local_to_world, filter);
  std::copy(std::begin(lookup.world_to_grid), std::end(lookup.world_to_grid), row.world_to_grid);
  row.outside = majorant.outside;
  if (majorant.entries.empty()) {
    std::fill_n(row.box_min, 3, 1.0f), std::fill_n(row.box_max, 3, -1.0f);
    return row;
  }
  const Vec3f lo = majorant.box.min, hi = majorant.box.max;
  const float lows[3] = {lo.x, lo.y, lo.z}, highs[3] = {hi.x, hi.y, hi.z};
  std::copy_n(lows, 3, row.box_min);
  std::copy_n(highs, 3, row.box_max);
  for (std::size_t axis = 0; axis < 3; ++axis) row.cells[axis] = static_cast<std::uint32_t>(majorant.cells[axis]);
  row.entries = majorant.entries.data();
  row.bounds = majorant.bounds.data();
  row.base_log2 = static_cast<std::uint32_t>(majorant.base_log2);
  return row;
}

}  // namespace sheaf
