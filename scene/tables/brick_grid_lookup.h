// Lookups in brick grids, for single points and for many points at a time.
#pragma once

#include "core/simd/truncate.h"
#include "scene/tables/brick_grid.h"

#include <bit>
#include <cstring>

namespace sheaf {

namespace detail {

/// Four floats in a register.
using NativeFloat4 = float __attribute__((vector_size(16)));

SHEAF_INLINE NativeFloat4 load_float4(const float* p) {
  NativeFloat4 v;
  std::memcpy(&v, p, sizeof(v));
  return v;
}
/// Loads two floats from each address. Assembled as doubles in a register, which avoids a store-forwarding stall.
SHEAF_INLINE NativeFloat4 load_pairs(const float* low, const float* high) {
  using Double2 = double __attribute__((vector_size(16)));
  double first, second;
  std::memcpy(&first, low, sizeof(first));
  std::memcpy(&second, high, sizeof(second));
  return std::bit_cast<NativeFloat4>(Double2{first, second});
}
SHEAF_INLINE NativeFloat4 lerp4(float t, NativeFloat4 a, NativeFloat4 b) { return (b - a) * t + a; }

/// A cell of a grid and a position inside it.
struct GridCell {
  const float* voxel;  ///< voxel at the lowest corner
  float tx, ty, tz;    ///< position in the cell, in [0, 1]
};

/// Wraps a coordinate into [0, cells) according to the border mode. Trilinear lookups that clamp or mirror use [0,
/// cells - 1], which gives the same values. NaN becomes 0.
SHEAF_INLINE float wrap_grid_coordinate(GridBorder border, bool nearest, float x, std::uint32_t cells) {
  const float n = static_cast<float>(cells), last = n - 1.0f;
  if (border == GridBorder::kRepeat) {
    const float wrapped = x - n * floor(x / n);
    return wrapped >= 0.0f && wrapped < n ? wrapped : 0.0f;
  }
  if (border == GridBorder::kMirror) {
    const float half = nearest ? 0.0f : 0.5f, period = n + n;
    const float u = x + half, folded = u - period * floor(u / period);
    x = (folded < n ? folded : period - folded) - half;
    if (nearest) return x > 0.0f ? (x < n ? x : last) : 0.0f;
  }
  return x > 0.0f ? (x < last ? x : last) : 0.0f;
}

/// Finds the cell at world-space point `p`. Returns false outside the grid, where the background applies.
SHEAF_INLINE bool find_grid_cell(const BrickGridRow& row, Vec3f p, int floats_per_voxel, GridCell& cell) {
  // Transform the point to the grid
  const NativeFloat4 g = load_float4(row.world_to_grid) * p.x +
                         (load_float4(row.world_to_grid + 4) * p.y +
                          (load_float4(row.world_to_grid + 8) * p.z + load_float4(row.world_to_grid + 12)));
  float x = g[0], y = g[1], z = g[2];
  const bool is_bounded = row.border == GridBorder::kBackground;
  if (!is_bounded) {
    x = wrap_grid_coordinate(row.border, row.nearest, x, row.cells[0]);
    y = wrap_grid_coordinate(row.border, row.nearest, y, row.cells[1]);
    z = wrap_grid_coordinate(row.border, row.nearest, z, row.cells[2]);
  }
  // Find the voxel, or leave the grid
  const std::int32_t ix = truncate(x), iy = truncate(y), iz = truncate(z);
  const auto ux = static_cast<std::uint32_t>(ix), uy = static_cast<std::uint32_t>(iy),
             uz = static_cast<std::uint32_t>(iz);
  if (is_bounded && ((min(x, min(y, z)) < 0.0f) | (ux >= row.cells[0]) | (uy >= row.cells[1]) | (uz >= row.cells[2])))
    return false;
  // Locate it in its brick
  const std::uint32_t brick = row.entries[(uz >> 3) * row.stride_z + (uy >> 3) * row.stride_y + (ux >> 3)];
  const std::uint32_t local = ((uz & 7) * kBrickStride + (uy & 7)) * kBrickStride + (ux & 7);
  cell.voxel = row.values + (std::size_t{brick} * kBrickVoxels + local) * static_cast<std::size_t>(floats_per_voxel);
  cell.tx = x - static_cast<float>(ix);
  cell.ty = y - static_cast<float>(iy);
  cell.tz = z - static_cast<float>(iz);
  return true;
}

}  // namespace detail

/// Value at a world-space point; the first channel of a three-channel grid. Any coordinates are safe. NaN counts as
/// outside, or as the start of the grid if there is no background.
SHEAF_INLINE float lookup_grid(const BrickGridRow& row, Vec3f p) {
  using namespace detail;
  if (row.channels != 1) [[unlikely]] {
    GridCell cell;
    if (!find_grid_cell(row, p, kColorVoxel, cell)) return row.background[0];
    if (row.nearest) return cell.voxel[0];
    const auto along_x = [&](int i) {
      return lerp(cell.tx, cell.voxel[i * kColorVoxel], cell.voxel[(i + 1) * kColorVoxel]);
    };
    constexpr int kY = kBrickStride, kZ = kBrickStride * kBrickStride;
    return lerp(cell.tz, lerp(cell.ty, along_x(0), along_x(kY)), lerp(cell.ty, along_x(kZ), along_x(kZ + kY)));
  }
  GridCell cell;
  if (!find_grid_cell(row, p, 1, cell)) return row.background[0];
  const float* const v = cell.voxel;
  if (row.nearest) return *v;
  constexpr int kY = kBrickStride, kZ = kBrickStride * kBrickStride;
  const NativeFloat4 yx = lerp4(cell.tz, load_pairs(v, v + kY), load_pairs(v + kZ, v + kZ + kY));
  const float low = lerp(cell.ty, yx[0], yx[2]), high = lerp(cell.ty, yx[1], yx[3]);
  return lerp(cell.tx, low, high);
}

/// Grid-space coordinates (the target space of BrickGridRow::world_to_grid) of world-space points.
template <class L> SHEAF_INLINE Vec3<L> to_grid(const BrickGridRow& row, Vec3<L> p) {
  using F = Float<L>;
  const float* const m = row.world_to_grid;
  const auto along = [&](int axis) SHEAF_LAMBDA_INLINE {
    return fma(F(m[axis]), p.x, fma(F(m[4 + axis]), p.y, fma(F(m[8 + axis]), p.z, F(m[12 + axis]))));
  };
  return {along(0), along(1), along(2)};
}

/// Value of a single-channel grid at many grid-space points (the target space of BrickGridRow::world_to_grid). The grid
/// is clamped or has a background, and fewer than 2^31 values. Points outside are moved to the nearest point of the
/// grid.
template <class L> SHEAF_INLINE Float<L> lookup_density(const BrickGridRow& row, Vec3<L> p) {
  using F = Float<L>;
  using U = Uint<L>;
  constexpr float kBelowOne = 1.0f - 6e-8f;
  const auto inside = [&](F x, std::uint32_t cells) SHEAF_LAMBDA_INLINE {
    const auto n = static_cast<float>(cells);
    return min(max(x, F(0.0f)), F(row.border == GridBorder::kBackground ? n * kBelowOne : n - 1.0f));
  };
  const F x = inside(p.x, row.cells[0]), y = inside(p.y, row.cells[1]), z = inside(p.z, row.cells[2]);
  const U ix = to_uint(x), iy = to_uint(y), iz = to_uint(z);
  const U brick = gather(row.entries, (iz >> 3) * U(row.stride_z) + (iy >> 3) * U(row.stride_y) + (ix >> 3));
  constexpr std::uint32_t kY = kBrickStride, kZ = kBrickStride * kBrickStride;
  const U local = ((iz & U(7u)) * U(kBrickStride) + (iy & U(7u))) * U(kBrickStride) + (ix & U(7u));
  const U voxel = brick * U(static_cast<std::uint32_t>(kBrickVoxels)) + local;
  if (row.nearest) return gather(row.values, voxel);
  const F tx = x - to_float(ix), ty = y - to_float(iy), tz = z - to_float(iz);
  const auto along_x = [&](std::uint32_t i) SHEAF_LAMBDA_INLINE {
    return lerp(tx, gather(row.values + i, voxel), gather(row.values + i + 1, voxel));
  };
  return lerp(tz, lerp(ty, along_x(0), along_x(kY)), lerp(ty, along_x(kZ), along_x(kZ + kY)));
}

/// As lookup_grid(), with three channels; gray for single-channel grids.
SHEAF_INLINE Vec3f lookup_grid_color(const BrickGridRow& row, Vec3f p) {
  using namespace detail;
  if (row.channels == 1) {
    const float v = lookup_grid(row, p);
    return {v, v, v};
  }
  GridCell cell;
  if (!find_grid_cell(row, p, kColorVoxel, cell)) return {row.background[0], row.background[1], row.background[2]};
  if (row.nearest) return {cell.voxel[0], cell.voxel[1], cell.voxel[2]};
  const auto along_x = [&](int i) {
    const float* const v = cell.voxel + i * kColorVoxel;
    return lerp4(cell.tx, load_float4(v), load_float4(v + kColorVoxel));
  };
  constexpr int kY = kBrickStride, kZ = kBrickStride * kBrickStride;
  const NativeFloat4 value =
      lerp4(cell.tz, lerp4(cell.ty, along_x(0), along_x(kY)), lerp4(cell.ty, along_x(kZ), along_x(kZ + kY)));
  return {value[0], value[1], value[2]};
}

/// As above, for the grid with index `grid`.
SHEAF_INLINE float lookup_grid(const BrickGridView& view, std::uint32_t grid, Vec3f p) {
  return lookup_grid(view.rows[grid], p);
}
SHEAF_INLINE Vec3f lookup_grid_color(const BrickGridView& view, std::uint32_t grid, Vec3f p) {
  return lookup_grid_color(view.rows[grid], p);
}

}  // namespace sheaf
