#include "scene/tables/majorant_grid.h"

#include <algorithm>

namespace sheaf {

namespace {

/// Lookups add up to eight products by weights that were rounded.
constexpr float kRounding = 1.0f + 4e-6f;

/// The largest value of each brick.
std::vector<float> brick_maxima(const BrickGrid& grid) {
  const std::size_t size = grid.brick_size(), voxel = grid.channels == 1 ? 1 : kColorVoxel;
  std::vector<float> maxima(grid.values.size() / size);
  for (std::size_t brick = 0; brick < maxima.size(); ++brick) {
    float most = -kInfinity;
    const float* const values = &grid.values[brick * size];
    for (std::size_t i = 0; i < size; i += voxel)
      for (std::size_t c = 0; c < static_cast<std::size_t>(grid.channels); ++c) most = std::max(most, values[i + c]);
    maxima[brick] = most;
  }
  return maxima;
}

/// The bricks that a cell takes values from, along one axis: [begin, end), and `also` if it is not negative.
struct BrickRange {
  int begin, end, also;
};

BrickRange bricks_of(const BrickGrid& grid, std::size_t axis, int cell, int bricks_per_cell) {
  const int begin = cell * bricks_per_cell, end = std::min(begin + bricks_per_cell, grid.bricks[axis]);
  // Half a voxel below the first voxel a repeated grid is interpolated from its last one.
  return {begin, end, grid.border == GridBorder::kRepeat && cell == 0 ? grid.bricks[axis] - 1 : -1};
}

template <class F> void for_each(const BrickRange& range, F&& f) {
  for (int i = range.begin; i < range.end; ++i) f(i);
  if (range.also >= range.end) f(range.also);
}

}  // namespace

float MajorantGrid::max_value() const {
  return bounds.empty() ? outside : std::max(outside, *std::max_element(bounds.begin(), bounds.end()));
}

MajorantGrid make_majorant_grid(const BrickGrid& grid, GridVolumeDescription::Filter filter, int max_side) {
  MajorantGrid result;
  const auto bound_of = [](float value) { return std::max(value, 0.0f) * kRounding; };
  if (grid.border == GridBorder::kBackground) {
    const auto used = grid.background.begin() + grid.channels;
    result.outside = bound_of(*std::max_element(grid.background.begin(), used));
  } else {
    result.outside = bound_of(grid.maximum);
  }
  if (grid.is_empty()) return result;
  const int longest = *std::max_element(grid.bricks.begin(), grid.bricks.end());
  result.bricks_per_cell = (longest + max_side - 1) / max_side;
  const float scale = 1.0f / static_cast<float>(kBrickSide * result.bricks_per_cell);
  const GridBox box = row_box(grid, filter);
  result.box = {box.min * scale, box.max * scale};
  for (std::size_t axis = 0; axis < 3; ++axis)
    result.cells[axis] = (grid.bricks[axis] + result.bricks_per_cell - 1) / result.bricks_per_cell;

  const std::vector<float> maxima = brick_maxima(grid);
  const auto range = [&](std::size_t axis, int cell) { return bricks_of(grid, axis, cell, result.bricks_per_cell); };
  for (int k = 0; k < result.cells[2]; ++k)
    for (int j = 0; j < result.cells[1]; ++j)
      for (int i = 0; i < result.cells[0]; ++i) {
        float most = 0;
        for_each(range(2, k), [&](int z) {
          for_each(range(1, j), [&](int y) {
            const auto row =
                static_cast<std::size_t>(z * grid.bricks[1] + y) * static_cast<std::size_t>(grid.bricks[0]);
            for_each(range(0, i), [&](int x) {
              most = std::max(most, maxima[grid.entries[row + static_cast<std::size_t>(x)]]);
            });
          });
        });
        result.bounds.push_back(bound_of(most));
      }
  return result;
}

MajorantGridRow make_majorant_grid_row(const MajorantGrid& majorant, const BrickGrid& grid,
                                       const Transform& local_to_world, GridVolumeDescription::Filter filter) {
  MajorantGridRow row;
  const BrickGridRow lookup = make_brick_grid_row(grid, local_to_world, filter);
  const float scale = 1.0f / static_cast<float>(kBrickSide * majorant.bricks_per_cell);
  for (std::size_t i = 0; i < 16; ++i) row.world_to_cells[i] = lookup.world_to_grid[i] * scale;
  const Vec3f lo = majorant.box.min, hi = majorant.box.max;
  const float lows[3] = {lo.x, lo.y, lo.z}, highs[3] = {hi.x, hi.y, hi.z};
  std::copy_n(lows, 3, row.box_min);
  std::copy_n(highs, 3, row.box_max);
  std::copy(majorant.cells.begin(), majorant.cells.end(), row.cells);
  row.bounds = majorant.bounds.data();
  row.outside = majorant.outside;
  if (majorant.bounds.empty()) std::fill_n(row.box_min, 3, 1.0f), std::fill_n(row.box_max, 3, -1.0f);
  return row;
}

}  // namespace sheaf
