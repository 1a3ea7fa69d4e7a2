// Majorant grids: bounds are conservative, and the segments of the walk tile the ray with the bounds of the right
// cells.
#include "kernels/media/majorant_walk.h"

#include "scene/compile/media/make_majorants.h"

#include "tests/support/near.h"
#include "tests/support/volume_testing.h"

#include <limits>

namespace sheaf::test_majorant_walk {

using namespace test;

namespace {

constexpr GridFilter kFilters[] = {GridFilter::kTrilinear, GridFilter::kNearest};

struct Bounded {
  TestGrid test;
  MajorantGrid majorant;
  BrickGridRow lookup;
  MajorantGridRow row;
};

Bounded bounded(TestGrid test, GridFilter filter, MajorantNeeds needs, const Transform& to_world) {
  Bounded b{std::move(test), {}, {}, {}};
  b.majorant = make_majorant_grid(b.test.grid, filter, needs);
  b.lookup = make_brick_grid_row(b.test.grid, to_world, filter);
  b.row = make_majorant_grid_row(b.majorant, b.test.grid, to_world, filter);
  return b;
}

std::vector<TestGrid> test_grids() {
  std::vector<TestGrid> grids;
  for (const GridBorder border : {GridBorder::kClamp, GridBorder::kRepeat, GridBorder::kMirror}) {
    grids.push_back(make_test_grid(1, {17, 8, 30}, border));
    grids.push_back(make_test_grid(3, {1, 20, 9}, border));
  }
  grids.push_back(make_sparse_test_grid(1, {{-3, 2, 0}, {-2, 2, 0}, {-3, 3, 1}, {1, 0, -1}, {1, 1, 1}}));
  grids.push_back(make_sparse_test_grid(3, {{0, 0, 0}, {4, 4, 4}}));
  return grids;
}

std::vector<MajorantSegment> segments_of(const MajorantGridRow& row, Vec3f o, Vec3f d, float t_min, float t_max) {
  std::vector<MajorantSegment> found;
  MajorantWalk walk(row, o, d, t_min, t_max);
  for (MajorantSegment s; walk.next(s);) {
    found.push_back(s);
    if (found.size() > 10000) break;
  }
  return found;
}

/// A grid of 4 x 3 x 2 different cells. The box is that of the cells, reduced by `inset` on each side.
struct SmallGrid {
  std::vector<float> bounds;
  std::vector<std::uint32_t> entries;
  std::vector<MajorantBounds> leaves;
  MajorantGridRow row;

  explicit SmallGrid(float inset = 0, float outside = 0) {
    const int cells[3] = {4, 3, 2};
    for (std::size_t i = 0; i < 24; ++i) bounds.push_back(static_cast<float>(i + 1));
    for (int axis = 0; axis < 3; ++axis) {
      row.world_to_grid[5 * axis] = 1;
      row.cells[axis] = static_cast<std::uint32_t>(cells[axis]);
      row.box_min[axis] = inset;
      row.box_max[axis] = static_cast<float>(cells[axis]) - inset;
    }
    for (std::uint32_t i = 0; i < 24; ++i) {
      entries.push_back(i << kMajorantSideBits);
      leaves.push_back(MajorantBounds::around(0.0f, bounds[i]));
    }
    row.entries = entries.data();
    row.bounds = leaves.data();
    row.outside = outside;
  }
  SmallGrid(const SmallGrid&) = delete;
  SmallGrid& operator=(const SmallGrid&) = delete;

  /// The bound at a point; `outside` beyond the box.
  float at(const double (&p)[3]) const {
    int cell[3];
    for (int axis = 0; axis < 3; ++axis) {
      const double lo = static_cast<double>(row.box_min[axis]), hi = static_cast<double>(row.box_max[axis]);
      if (p[axis] < lo || p[axis] > hi) return row.outside;
      cell[axis] = std::clamp(static_cast<int>(std::floor(p[axis])), 0, static_cast<int>(row.cells[axis]) - 1);
    }
    return bounds[static_cast<std::size_t>((cell[2] * 3 + cell[1]) * 4 + cell[0])];
  }
};

/// Whether a point is near a plane between cells or a face of the box.
bool is_near_plane(const SmallGrid& grid, const double (&p)[3], double distance) {
  for (int axis = 0; axis < 3; ++axis) {
    for (const double plane : {std::round(p[axis]), static_cast<double>(grid.row.box_min[axis]),
                               static_cast<double>(grid.row.box_max[axis])})
      if (std::fabs(p[axis] - plane) < distance) return true;
  }
  return false;
}

/// Compares the segments with the bounds at many points along the ray.
void check_walk(const SmallGrid& grid, Vec3f o, Vec3f d, float t_min, float t_max) {
  const auto segments = segments_of(grid.row, o, d, t_min, t_max);
  INFO("ray from ", o.x, " ", o.y, " ", o.z, " towards ", d.x, " ", d.y, " ", d.z);
  REQUIRE(segments.size() < 100);
  for (std::size_t i = 0; i < segments.size(); ++i) {
    CHECK(segments[i].t0 < segments[i].t1);
    if (i > 0) CHECK(segments[i].t0 == segments[i - 1].t1);
  }
  if (!segments.empty()) {
    CHECK(segments.front().t0 >= t_min);
    CHECK(segments.back().t1 <= t_max);
  }
  constexpr int kSteps = 997;
  int wrong = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double t = static_cast<double>(t_min) + (i + 0.5) / kSteps * static_cast<double>(t_max - t_min);
    const double p[3] = {static_cast<double>(o.x) + t * static_cast<double>(d.x),
                         static_cast<double>(o.y) + t * static_cast<double>(d.y),
                         static_cast<double>(o.z) + t * static_cast<double>(d.z)};
    if (is_near_plane(grid, p, 1e-4)) continue;
    float bound = 0;
    for (const MajorantSegment& s : segments)
      if (t >= static_cast<double>(s.t0) && t < static_cast<double>(s.t1)) bound = s.bound;
    wrong += bound != grid.at(p);
  }
  CHECK(wrong == 0);
}

Vec3f random_point(std::uint32_t i, std::uint32_t stream, float lo, float hi) {
  return {lo + (hi - lo) * noise(i, stream), lo + (hi - lo) * noise(i, stream + 1),
          lo + (hi - lo) * noise(i, stream + 2)};
}

/// Extent of a leaf along one axis, within the box.
struct Reach {
  float lo, hi;
};

Reach reach_of(const Bounded& b, int axis, float low, float side) {
  const float end = static_cast<float>(b.row.cells[axis] << b.row.base_log2);
  return {low == 0.0f ? b.row.box_min[axis] : low, low + side >= end ? b.row.box_max[axis] : low + side};
}

/// Samples random points of the leaf around a voxel; returns how many values exceed its bounds.
int beyond_bounds(const Bounded& b, std::array<int, 3> voxel, int positions, std::uint32_t& number) {
  LeafWalk<Scalar> walk{};
  walk.position = {static_cast<float>(voxel[0]), static_cast<float>(voxel[1]), static_cast<float>(voxel[2])};
  const MajorantLeaf<Scalar> leaf = find_leaf<Scalar>(b.row, walk);
  CHECK(leaf.minorant <= leaf.majorant);
  const float lows[3] = {leaf.low.x, leaf.low.y, leaf.low.z};
  int beyond = 0;
  for (int i = 0; i < positions; ++i, ++number) {
    float p[3];
    bool is_empty = false;
    for (std::uint32_t axis = 0; axis < 3; ++axis) {
      const Reach reach = reach_of(b, static_cast<int>(axis), lows[axis], leaf.side);
      const float lo = std::max(reach.lo, b.row.box_min[axis]), hi = std::min(reach.hi, b.row.box_max[axis]);
      is_empty |= !(lo < hi);
      p[axis] = lo + (hi - lo) * (0.0001f + 0.9998f * noise(number, 20 + axis)) - b.lookup.world_to_grid[12 + axis];
    }
    if (is_empty) break;
    const Vec3f v = lookup_grid_color(b.lookup, {p[0], p[1], p[2]});
    beyond += !(max_component(v) <= leaf.majorant);
    beyond += !(std::max(std::min({v.x, v.y, v.z}), 0.0f) >= leaf.minorant);
  }
  return beyond;
}

}  // namespace

TEST_CASE("majorant grid: bounds hold everywhere in leaves of all sizes") {
  std::vector<int> sides(16);
  for (const TestGrid& grid : test_grids())
    for (const GridFilter filter : kFilters)
      for (const int max_side : {64, 2, 1})
        for (const float thickness : {0.0f, 0.02f, 0.3f, 10.0f}) {
          const Bounded b = bounded(grid, filter, {thickness, true, true, max_side}, Transform());
          for (const int side : b.majorant.cells) CHECK(side <= max_side);
          int beyond = 0;
          std::uint32_t number = 0;
          const int step = thickness > 0.0f ? 3 : 1 << b.majorant.base_log2;
          std::array<int, 3> v{};
          for (v[2] = 0; v[2] < b.majorant.cells[2] << b.majorant.base_log2; v[2] += step)
            for (v[1] = 0; v[1] < b.majorant.cells[1] << b.majorant.base_log2; v[1] += step)
              for (v[0] = 0; v[0] < b.majorant.cells[0] << b.majorant.base_log2; v[0] += step)
                beyond += beyond_bounds(b, v, thickness > 0.0f ? 4 : 200, number);
          CHECK(beyond == 0);
          for (const std::uint32_t entry : b.majorant.entries) ++sides[entry & ((1u << kMajorantSideBits) - 1u)];
        }
  for (std::size_t log2 = 0; log2 <= 5; ++log2) {
    CAPTURE(log2);
    CHECK(sides[log2] > 0);
  }
}

TEST_CASE("majorant grid: the leaf size follows the detail of the volume") {
  // One half is constant, the other has waves of about ten voxels.
  std::vector<float> values(64 * 64 * 64);
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] = i % 64 < 32 ? 1.0f : 0.5f + 0.5f * std::sin(0.6f * static_cast<float>(i % 64));
  const BrickGrid grid = make_dense_grid(1, {64, 64, 64}, values, GridBorder::kClamp);
  const auto side_at = [&](const MajorantGrid& m, std::size_t x) { return 1u << (m.entries[x] & 31u); };
  const MajorantGrid thin = make_majorant_grid(grid, GridFilter::kTrilinear, {1e-4f}),
                     thick = make_majorant_grid(grid, GridFilter::kTrilinear, {1.0f});
  CHECK(side_at(thin, 0) >= 64);
  CHECK(thin.bounds.size() == 2);
  CHECK(side_at(thick, 0) >= 8);
  CHECK(side_at(thick, 4) == 2);
  const MajorantGrid thicker = make_majorant_grid(grid, GridFilter::kTrilinear, {2.0f});
  CHECK(side_at(thicker, 4) == 1);
  // Leaves of single voxels are omitted if they would take too much memory.
  const MajorantGrid thickest = make_majorant_grid(grid, GridFilter::kTrilinear, {100.0f});
  CHECK(thick.bytes() < thickest.bytes());
  CHECK(2 * thickest.bytes() <= grid.bytes());
}

TEST_CASE("majorant walk: random rays visit the leaves of all sizes with valid bounds") {
  int segments_seen = 0;
  for (const TestGrid& grid : test_grids())
    for (const float thickness : {0.02f, 0.3f, 10.0f}) {
      const Bounded b = bounded(grid, GridFilter::kTrilinear, {thickness, true}, skewed_transform());
      int above = 0, gaps = 0;
      for (std::uint32_t i = 0; i < 150; ++i) {
        const Vec3f o = random_point(i, 60, -150, 150), target = random_point(i, 63, -30, 60);
        const Vec3f d = normalize(target - o);
        const auto segments = segments_of(b.row, o, d, 0, 1e6f);
        REQUIRE(segments.size() < 1000);
        for (std::size_t k = 0; k < segments.size(); ++k) {
          const MajorantSegment& s = segments[k];
          gaps += k > 0 && s.t0 != segments[k - 1].t1;
          gaps += !(s.t0 < s.t1);
          ++segments_seen;
          if (!(s.t1 < 1e6f)) continue;
          for (int step = 0; step < 4; ++step) {
            const float u = 0.05f + 0.3f * static_cast<float>(step);
            const float t = s.t0 + (s.t1 - s.t0) * u;
            // Points within a rounding error of a face may be in the neighbor.
            if (s.t1 - s.t0 < 0.01f) continue;
            above += max_component(lookup_grid_color(b.lookup, o + d * t)) > s.bound;
          }
        }
      }
      CHECK(above == 0);
      CHECK(gaps == 0);
    }
  CHECK(segments_seen > 5000);
}

TEST_CASE("majorant walk: leaves beyond the table do not lead a ray out of it") {
  // Three bricks along each axis, so the last leaves of two bricks are half outside.
  const std::vector<float> values(24 * 24 * 24, 0.5f);
  BrickGrid grid = make_dense_grid(1, {24, 24, 24}, values, GridBorder::kClamp);
  MajorantGrid majorant = make_majorant_grid(grid, GridFilter::kNearest, {0.1f});
  for (std::uint32_t& entry : majorant.entries) entry = (entry & ~31u) | 4u;
  const MajorantGridRow row = make_majorant_grid_row(majorant, grid, Transform(), GridFilter::kNearest);
  const Vec3f corner = {row.box_max[0], row.box_max[1], row.box_max[2]};
  int outside = 0, steps = 0;
  for (std::uint32_t i = 0; i < 20000; ++i) {
    // Aim at edges where a leaf ends just before the box does.
    const Vec3f o = random_point(i, 70, -30, 10), target{corner.x, 16, 20 * noise(i, 73)};
    bool hits;
    auto walk = start_leaf_walk<Scalar>(row, o, normalize(target - o), 0, 1e6f, hits);
    for (; hits; ++steps) {
      outside += !(max_component(walk.position) < 24.0f);
      const auto leaf = find_leaf<Scalar>(row, walk);
      if (!(leaf.t_end < walk.leave)) break;
      walk.position = position_behind<Scalar>(row, walk, leaf);
    }
  }
  CHECK(outside == 0);
  CHECK(steps > 1000);
}

TEST_CASE("majorant grid: the bound outside the box is zero for sparse grids and the maximum for others") {
  for (const TestGrid& grid : test_grids())
    for (const GridFilter filter : kFilters) {
      const Bounded b = bounded(grid, filter, {}, skewed_transform());
      const bool is_sparse = grid.grid.border == GridBorder::kBackground;
      CHECK(b.row.outside == near(is_sparse ? 0.0f : grid.grid.max_value()));
      int above = 0, outside = 0;
      for (std::uint32_t i = 0; i < 20000; ++i) {
        const Vec3f p = random_point(i, 30, -120, 120);
        const float* const m = b.row.world_to_grid;
        bool is_inside = true;
        for (int axis = 0; axis < 3; ++axis) {
          const float q = m[axis] * p.x + m[4 + axis] * p.y + m[8 + axis] * p.z + m[12 + axis];
          is_inside &= q >= b.row.box_min[axis] - 1e-3f && q <= b.row.box_max[axis] + 1e-3f;
        }
        if (is_inside) continue;
        ++outside;
        above += max_component(lookup_grid_color(b.lookup, p)) > b.row.outside;
      }
      CHECK(outside > 1000);
      CHECK(above == 0);
    }
}

TEST_CASE("majorant grid: the first cell of a repeated grid includes its last voxel") {
  std::vector<float> values(25, 0.0f);
  values[24] = 10;
  const BrickGrid grid = make_dense_grid(1, {25, 1, 1}, values, GridBorder::kRepeat);
  const MajorantGrid majorant = make_majorant_grid(grid, GridFilter::kTrilinear);
  REQUIRE(majorant.entries.size() == 4);
  const auto bounds_at = [](const MajorantGrid& m, std::size_t cell) { return m.bounds[m.entries[cell] >> 5]; };
  CHECK(bounds_at(majorant, 0).majorant() >= 5.0f);
  CHECK(bounds_at(majorant, 1).majorant() == 0.0f);
  // After subdivision, only the leaves at the beginning have the large bound.
  const MajorantGrid fine = make_majorant_grid(grid, GridFilter::kTrilinear, {10.0f});
  CHECK(bounds_at(fine, 0).majorant() >= 5.0f);
  REQUIRE((fine.entries[0] & 31u) < 3);
  CHECK(fine.bounds[(fine.entries[0] >> 5) + 1].majorant() == 0.0f);
}

TEST_CASE("majorant grid: empty volumes and negative values are bounded by zero") {
  const BrickGrid empty = make_sparse_grid(VoxelBlocks(1));
  const MajorantGrid none = make_majorant_grid(empty, GridFilter::kTrilinear);
  CHECK(none.max_value() == 0.0f);
  const MajorantGridRow row = make_majorant_grid_row(none, empty, Transform(), GridFilter::kTrilinear);
  CHECK(segments_of(row, {0, 0, 0}, {1, 1, 1}, 0, 10).empty());
  const std::vector<float> values(8, -3.0f);
  const BrickGrid negative = make_dense_grid(1, {2, 2, 2}, values, GridBorder::kClamp);
  CHECK(make_majorant_grid(negative, GridFilter::kTrilinear).max_value() == 0.0f);
}

TEST_CASE("majorant walk: random rays agree with ray marching") {
  for (const float inset : {0.0f, 0.25f})
    for (const float outside : {0.0f, 99.0f}) {
      const SmallGrid grid(inset, outside);
      for (std::uint32_t i = 0; i < 500; ++i) {
        const Vec3f o = random_point(i, 40, -2, 6), target = random_point(i, 43, 0.1f, 3);
        const float speed = 0.05f + 5 * noise(i, 46);
        const float t_min = i % 2 == 0 ? 0.0f : noise(i, 47);
        check_walk(grid, o, (target - o) * speed, t_min, t_min + 3 * noise(i, 48) / speed + 1e-3f);
      }
    }
}

TEST_CASE("majorant walk: rays along axes and diagonals and in faces agree with ray marching") {
  for (const float outside : {0.0f, 99.0f}) {
    const SmallGrid grid(0, outside);
    const float starts[] = {-1, 0, 0.5f, 1, 1.5f, 2, 3, 4, 5};
    for (int code = 1; code < 27; ++code) {
      const int x_sign = code % 3 - 1, y_sign = code / 3 % 3 - 1, z_sign = code / 9 - 1;
      const Vec3f d{static_cast<float>(x_sign), static_cast<float>(y_sign), static_cast<float>(z_sign)};
      if (d == Vec3f{0, 0, 0}) continue;
      for (const float x : starts)
        for (const float y : starts)
          for (const float z : {-1.0f, 0.0f, 0.5f, 1.0f, 2.0f}) {
            const auto segments = segments_of(grid.row, {x, y, z}, d, 0, 10);
            REQUIRE(segments.size() < 20);
            float reached = segments.empty() ? 0 : segments[0].t0, bound = 0;
            for (const MajorantSegment& s : segments) {
              CHECK(s.t0 == reached);
              CHECK(s.t1 > s.t0);
              reached = s.t1;
              bound = std::max(bound, s.bound);
            }
            if (outside > 0) CHECK(reached == 10.0f);
            CHECK(bound <= 99.0f);
            check_walk(grid, {x + 0.01f, y + 0.02f, z + 0.03f}, d, 0, 10);
          }
    }
  }
  const SmallGrid grid;
  const auto along = segments_of(grid.row, {-1, 0.5f, 1.5f}, {2, 0, 0}, 0, 100);
  REQUIRE(along.size() == 4);
  for (std::size_t i = 0; i < 4; ++i) {
    CHECK(along[i].t0 == 0.5f + 0.5f * static_cast<float>(i));
    CHECK(along[i].bound == static_cast<float>(12 + i + 1));
  }
  CHECK(along[3].t1 == 2.5f);
}

TEST_CASE("majorant walk: zero lengths and infinite ends and zero or NaN directions are handled") {
  const SmallGrid grid, clamped(0, 99);
  const Vec3f inside{0.5f, 0.5f, 0.5f};
  CHECK(segments_of(grid.row, inside, {1, 0, 0}, 1, 1).empty());
  CHECK(segments_of(clamped.row, inside, {1, 0, 0}, 1, 1).empty());
  CHECK(segments_of(grid.row, inside, {1, 0, 0}, 2, 1).empty());
  CHECK(segments_of(clamped.row, inside, {1, 0, 0}, 2, 1).empty());
  CHECK(segments_of(grid.row, inside, {-1, 0, 0}, 0.5f, 9).empty());
  const auto endless = segments_of(grid.row, inside, {1, 0, 0}, 0, kInfinity);
  REQUIRE(endless.size() == 4);
  CHECK(endless[3].t1 == 3.5f);
  const auto around = segments_of(clamped.row, {-1, 0.5f, 0.5f}, {1, 0, 0}, 0, kInfinity);
  REQUIRE(around.size() == 6);
  CHECK(around[0].bound == 99.0f);
  CHECK(around[0].t1 == 1.0f);
  CHECK(around[5].bound == 99.0f);
  CHECK(around[5].t1 == kInfinity);
  const auto missed = segments_of(clamped.row, {-1, 5, 0.5f}, {1, 0, 0}, 0, kInfinity);
  REQUIRE(missed.size() == 1);
  CHECK(missed[0].bound == 99.0f);
  const auto standing = segments_of(grid.row, inside, {0, 0, 0}, 0, 3);
  REQUIRE(standing.size() == 1);
  CHECK(standing[0].bound == 1.0f);
  CHECK(segments_of(grid.row, {-1, 0, 0}, {0, 0, 0}, 0, 3).empty());
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  CHECK(segments_of(grid.row, {kNan, 0, 0}, {1, 0, 0}, 0, 3).empty());
  CHECK(segments_of(grid.row, inside, {kNan, 1, 1}, 0, 3).size() < 10);
}

TEST_CASE("majorant walk: distant and nearly parallel and short rays are handled") {
  const SmallGrid grid;
  for (std::uint32_t i = 0; i < 2000; ++i) {
    const Vec3f target = random_point(i, 50, 0.2f, 1.8f), from = random_point(i, 53, -1, 1);
    Vec3f d = normalize(target - (target + from));
    if (i % 3 == 1) d.x *= 1e-7f;
    if (i % 3 == 2) d.y *= 1e-33f;
    const float far = i % 2 == 0 ? 1000.0f : 3.0f;
    const auto segments = segments_of(grid.row, target - d * far, d, 0, 1e6f);
    REQUIRE(segments.size() < 12);
    REQUIRE_FALSE(segments.empty());
    double sum = 0;
    for (std::size_t k = 0; k < segments.size(); ++k) {
      if (k > 0) CHECK(segments[k].t0 == segments[k - 1].t1);
      sum += static_cast<double>(segments[k].t1 - segments[k].t0);
    }
    double enter = -1e30, leave = 1e30;
    const double o[3] = {static_cast<double>(target.x), static_cast<double>(target.y), static_cast<double>(target.z)},
                 v[3] = {static_cast<double>(d.x), static_cast<double>(d.y), static_cast<double>(d.z)};
    for (int axis = 0; axis < 3; ++axis) {
      if (std::fabs(v[axis]) < 1e-30) continue;
      const double a = -o[axis] / v[axis], b = (grid.row.cells[axis] - o[axis]) / v[axis];
      enter = std::max(enter, std::min(a, b));
      leave = std::min(leave, std::max(a, b));
    }
    CHECK(std::fabs(sum - (leave - std::max(enter, -static_cast<double>(far)))) < 1e-2);
  }
}

TEST_CASE("majorant walk: every walk ends") {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  const float extremes[] = {0, 1.5f, -1e-40f, 1e-30f, 1e18f, -3e38f, kInfinity, -kInfinity, kNan};
  std::size_t most = 0;
  for (const float outside : {0.0f, 1.0f}) {
    const SmallGrid grid(0.25f, outside);
    for (const float x : extremes)
      for (const float y : extremes)
        for (const float dx : extremes)
          for (const float dy : extremes)
            for (const float dz : extremes)
              for (const float t_max : {1.0f, 1e18f, kInfinity, kNan})
                most = std::max(most, segments_of(grid.row, {x, y, 0.5f}, {dx, dy, dz}, 0, t_max).size());
  }
  CHECK(most > 1);
  CHECK(most <= 4 + 3 + 2 + 2);
}

}  // namespace sheaf::test_majorant_walk
