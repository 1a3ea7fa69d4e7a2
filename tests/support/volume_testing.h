// Helpers for tests of volumes: noise grids, stored both as bricks and as a plain array.
#pragma once

#include "core/sampling/rng.h"
#include "scene/compile/media/build_brick_grid.h"
#include "scene/tables/brick_grid_lookup.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

namespace sheaf::test {

/// Uniform in [0, 1).
inline float noise(std::uint32_t i, std::uint32_t stream) { return random4<Scalar>(stream, i, 0, 0).x; }

/// A rotation, a shear and a translation with a determinant of about -8.
inline Transform skewed_transform() {
  Matrix4 shear;
  shear.m[0][1] = 0.3;
  return Transform::translate({1, -2, 3}) * Transform::rotate({1, 2, -1}, 40) * Transform(shear) *
         Transform::scale({2, -1.5f, 2.5f});
}

/// Voxels in a plain array with a naive lookup in double precision.
struct DenseReference {
  int channels = 1;
  std::array<int, 3> first{}, size{};
  GridBorder border = GridBorder::kBackground;
  std::array<float, 3> background{};
  std::vector<float> values;  ///< x fastest, channels interleaved

  static int wrap(GridBorder border, long long i, int n) {
    if (border == GridBorder::kClamp) return static_cast<int>(std::clamp(i, 0LL, n - 1LL));
    const long long period = border == GridBorder::kMirror ? 2LL * n : n;
    const auto folded = static_cast<int>((i % period + period) % period);
    return folded < n ? folded : 2 * n - 1 - folded;
  }

  double voxel(long long x, long long y, long long z, int c) const {
    long long at[3] = {x - first[0], y - first[1], z - first[2]};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (border != GridBorder::kBackground) at[axis] = wrap(border, at[axis], size[axis]);
      if (at[axis] < 0 || at[axis] >= size[axis]) return static_cast<double>(background[static_cast<std::size_t>(c)]);
    }
    const long long i = (at[2] * size[1] + at[1]) * size[0] + at[0];
    return static_cast<double>(values[static_cast<std::size_t>(i * channels + c)]);
  }

  /// Value of channel `c` at a point in index space.
  double lookup(const std::array<double, 3>& p, int c, GridFilter filter) const {
    long long i[3];
    double t[3];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double shifted = p[axis] + (filter == GridFilter::kNearest ? 0.5 : 0.0);
      i[axis] = static_cast<long long>(std::floor(shifted));
      t[axis] = shifted - static_cast<double>(i[axis]);
    }
    if (filter == GridFilter::kNearest) return voxel(i[0], i[1], i[2], c);
    double sum = 0;
    for (int corner = 0; corner < 8; ++corner) {
      const int dx = corner & 1, dy = corner >> 1 & 1, dz = corner >> 2;
      sum += (dx != 0 ? t[0] : 1 - t[0]) * (dy != 0 ? t[1] : 1 - t[1]) * (dz != 0 ? t[2] : 1 - t[2]) *
             voxel(i[0] + dx, i[1] + dy, i[2] + dz, c);
    }
    return sum;
  }
};

/// A grid and its reference.
struct TestGrid {
  BrickGrid grid;
  DenseReference reference;
};

/// Noise in [-1, 2] in every voxel.
inline TestGrid make_test_grid(int channels, std::array<int, 3> size, GridBorder border) {
  TestGrid result;
  DenseReference& r = result.reference;
  r.channels = channels;
  r.size = size;
  r.border = border;
  r.values.resize(static_cast<std::size_t>(size[0] * size[1] * size[2] * channels));
  for (std::size_t i = 0; i < r.values.size(); ++i) r.values[i] = 3 * noise(static_cast<std::uint32_t>(i), 1) - 1;
  result.grid = make_dense_grid(channels, size, r.values, border);
  return result;
}

/// Noise in some voxels of the blocks at `positions`, every third of which is constant; all other voxels are
/// background.
inline TestGrid make_sparse_test_grid(int channels, const std::vector<std::array<int, 3>>& positions,
                                      std::array<float, 3> background = {}) {
  TestGrid result;
  DenseReference& r = result.reference;
  r.channels = channels;
  r.background = background;
  std::array<int, 3> lo = positions[0], hi = positions[0];
  for (const auto& p : positions)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      lo[axis] = std::min(lo[axis], p[axis]);
      hi[axis] = std::max(hi[axis], p[axis]);
    }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    r.first[axis] = lo[axis] * 8;
    r.size[axis] = (hi[axis] - lo[axis] + 1) * 8;
  }
  const auto c = static_cast<std::size_t>(channels);
  r.values.resize(static_cast<std::size_t>(r.size[0] * r.size[1] * r.size[2]) * c);
  for (std::size_t i = 0; i < r.values.size(); ++i) r.values[i] = background[i % c];
  VoxelBlocks blocks(channels, background);
  std::uint32_t number = 0;
  for (const auto& p : positions) {
    const bool is_constant = ++number % 3 == 0;
    const std::vector<float> value(c, 0.25f * static_cast<float>(number));
    if (is_constant) blocks.add_constant(p, value);
    const std::span<float> added = is_constant ? std::span<float>() : blocks.add(p);
    for (int i = 0; i < VoxelBlocks::kVoxels; ++i) {
      const int x = p[0] * 8 + (i & 7) - r.first[0], y = p[1] * 8 + (i >> 3 & 7) - r.first[1],
                z = p[2] * 8 + (i >> 6) - r.first[2];
      for (std::size_t k = 0; k < c; ++k) {
        const auto at = static_cast<std::size_t>((z * r.size[1] + y) * r.size[0] + x) * c + k;
        const float random = noise(number * 512 + static_cast<std::uint32_t>(i), 2 + static_cast<std::uint32_t>(k));
        if (is_constant)
          r.values[at] = value[k];
        else if (random < 0.7f)
          added[static_cast<std::size_t>(i) * c + k] = r.values[at] = random;
      }
    }
  }
  result.grid = make_sparse_grid(blocks);
  return result;
}

/// The point of the reference's index space for a point in world space.
inline std::array<double, 3> to_index_space(const BrickGrid& grid, const Transform& local_to_world, Vec3f p) {
  const auto m = (local_to_world * grid.grid_to_local).inverse_matrix().m;
  std::array<double, 3> q{};
  for (std::size_t row = 0; row < 3; ++row)
    q[row] = m[row][0] * static_cast<double>(p.x) + m[row][1] * static_cast<double>(p.y) +
             m[row][2] * static_cast<double>(p.z) + m[row][3];
  return q;
}

}  // namespace sheaf::test
