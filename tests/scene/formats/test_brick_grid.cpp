// Brick grids against a plain array: both filters, all borders, one and three channels, sparse and dense.
#include "tests/support/volume_testing.h"

#include <limits>

namespace sheaf::test_brick_grid {

using namespace test;

namespace {

constexpr GridFilter kFilters[] = {GridFilter::kTrilinear, GridFilter::kNearest};
constexpr GridBorder kBorders[] = {GridBorder::kClamp, GridBorder::kRepeat, GridBorder::kMirror};

/// Compares values at random positions in a box that exceeds the grid by `beyond` voxels.
void check_lookups(const TestGrid& t, GridFilter filter, float beyond, std::uint32_t count) {
  const Transform to_world = skewed_transform();
  const BrickGridRow row = make_brick_grid_row(t.grid, to_world, filter);
  const DenseReference& r = t.reference;
  int differences = 0;
  for (std::uint32_t i = 0; i < count; ++i) {
    float q[3];
    for (std::uint32_t axis = 0; axis < 3; ++axis)
      q[axis] = static_cast<float>(r.first[axis]) - beyond +
                noise(i, 10 + axis) * (static_cast<float>(r.size[axis]) + 2 * beyond);
    const Vec3f world = (to_world * t.grid.grid_to_local).point({q[0], q[1], q[2]});
    const auto position = to_index_space(t.grid, to_world, world);
    bool is_between = false;  // on the line between voxels, where rounding decides
    for (const double x : position) is_between |= std::fabs(x + 0.5 - std::round(x + 0.5)) < 1e-3;
    if (filter == GridFilter::kNearest && is_between) continue;
    const Vec3f color = lookup_grid_color(row, world);
    const float found[3] = {color.x, color.y, color.z};
    for (int c = 0; c < 3; ++c) {
      const double expected = r.lookup(position, r.channels == 1 ? 0 : c, filter);
      differences += !(std::fabs(static_cast<double>(found[c]) - expected) < 2e-4);
    }
    differences += !(std::fabs(lookup_grid(row, world) - found[0]) < 1e-6f);
    differences += !(found[0] <= t.grid.max_value() * 1.000001f + 1e-6f && found[0] >= t.grid.minimum - 1e-5f);
  }
  CHECK(differences == 0);
}

}  // namespace

TEST_CASE("brick grid: dense grids of all sizes match a direct lookup with all borders and filters") {
  const std::array<int, 3> sizes[] = {{1, 1, 1}, {2, 3, 1}, {7, 8, 9}, {8, 8, 8}, {16, 17, 15}, {1, 40, 2}};
  for (const auto& size : sizes)
    for (const GridBorder border : kBorders)
      for (const int channels : {1, 3}) {
        const TestGrid t = make_test_grid(channels, size, border);
        for (const GridFilter filter : kFilters) check_lookups(t, filter, 25, 3000);
      }
}

TEST_CASE("brick grid: sparse grids with scattered blocks match a direct lookup") {
  for (const int channels : {1, 3}) {
    for (const GridFilter filter : kFilters) {
      check_lookups(make_sparse_test_grid(channels, {{0, 0, 0}}), filter, 3, 5000);
      check_lookups(
          make_sparse_test_grid(channels, {{-3, 2, 0}, {-2, 2, 0}, {-3, 3, 1}, {1, 0, -1}, {1, 1, 1}, {0, 0, 0}}),
          filter, 10, 20000);
      check_lookups(make_sparse_test_grid(channels, {{5, 5, 5}, {6, 5, 5}, {5, 6, 5}, {5, 6, 6}}, {0.5f, 0.25f, 1}),
                    filter, 10, 20000);
    }
  }
}

TEST_CASE("brick grid: constant bricks are stored once") {
  VoxelBlocks blocks(1);
  const float one = 1, two = 2;
  for (int x = 0; x < 20; ++x)
    for (int y = 0; y < 20; ++y)
      for (int z = 0; z < 20; ++z) blocks.add_constant({x, y, z}, {x < 10 ? &one : &two, 1});
  const BrickGrid grid = make_sparse_grid(blocks);
  CHECK(grid.bricks == std::array<int, 3>{21, 21, 21});
  CHECK(grid.first == std::array<int, 3>{-8, -8, -8});
  CHECK(grid.voxel_min == std::array<int, 3>{0, 0, 0});
  CHECK(grid.voxel_max == std::array<int, 3>{159, 159, 159});
  CHECK(grid.max_value() == 2.0f);
  CHECK(grid.minimum == 0.0f);
  // Two inside bricks, and those of the border and of the middle plane, which vary.
  const std::size_t bricks = grid.values.size() / grid.brick_size();
  CHECK(bricks == 21 * 21 * 21 - (9 + 9) * 19 * 19 + 2);
  const std::vector<float> alike(100 * 100 * 100, 0.5f);
  const BrickGrid dense = make_dense_grid(1, {100, 100, 100}, alike, GridBorder::kRepeat);
  CHECK(dense.values.size() == dense.brick_size());
}

TEST_CASE("brick grid: grids have the right bounds in local space and in that of lookups") {
  TestGrid t = make_sparse_test_grid(1, {{1, 2, 3}});
  t.grid.grid_to_local = Transform::scale({0.5f, 0.5f, -0.5f});
  const auto& lo = t.grid.voxel_min;
  const auto& hi = t.grid.voxel_max;
  CHECK(t.grid.voxel_box().min.x == 0.5f * (static_cast<float>(lo[0]) - 0.5f));
  CHECK(t.grid.voxel_box().max.z == -0.5f * (static_cast<float>(lo[2]) - 0.5f));
  // Values towards the background are interpolated over one voxel; nearest lookups are shifted by half a voxel
  const auto end = static_cast<float>(hi[1] - t.grid.first[1]);
  CHECK(row_box(t.grid, GridFilter::kTrilinear).max.y == end + 1);
  CHECK(row_box(t.grid, GridFilter::kNearest).max.y == end + 0.5f + 0.5f);
  const auto begin = static_cast<float>(lo[1] - t.grid.first[1]);
  CHECK(row_box(t.grid, GridFilter::kTrilinear).min.y == begin - 1);
  CHECK(row_box(t.grid, GridFilter::kNearest).min.y == begin);
}

TEST_CASE("brick grid: empty grids have the background value everywhere") {
  VoxelBlocks blocks(3, {1, 2, 3});
  blocks.add({4, 4, 4});
  for (const BrickGrid& grid : {make_sparse_grid(VoxelBlocks(3, {1, 2, 3})), make_sparse_grid(blocks)}) {
    CHECK(grid.is_empty());
    CHECK(grid.max_value() == 3.0f);
    CHECK(grid.voxel_box().min.x > grid.voxel_box().max.x);
    for (const GridFilter filter : kFilters) {
      const BrickGridRow row = make_brick_grid_row(grid, Transform(), filter);
      CHECK(lookup_grid_color(row, {0, 0, 0}) == Vec3f{1, 2, 3});
      CHECK(lookup_grid(row, {33, 33, 33}) == 1.0f);
    }
  }
}

TEST_CASE("brick grid: no coordinate leads outside the table") {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  const float extremes[] = {0,     -0.0f, 1e-40f, -1e-40f, 7.5f,   8,         -1,         0.49999997f, 16.0f,
                            15.5f, 1e9f,  -1e9f,  3e38f,   -3e38f, kInfinity, -kInfinity, kNan};
  for (const GridFilter filter : kFilters) {
    std::vector<TestGrid> grids;
    for (const GridBorder border : kBorders) grids.push_back(make_test_grid(1, {16, 16, 16}, border));
    grids.push_back(make_sparse_test_grid(1, {{0, 0, 0}, {1, 1, 1}}));
    for (const TestGrid& t : grids) {
      const BrickGridRow row = make_brick_grid_row(t.grid, Transform(), filter);
      for (const float x : extremes)
        for (const float y : extremes)
          for (const float z : extremes) CHECK(std::fabs(lookup_grid(row, {x, y, z})) <= 2.0f);
    }
  }
}

TEST_CASE("brick grid: impossible sizes are errors") {
  const std::vector<float> none;
  CHECK_THROWS_AS(make_dense_grid(1, {0, 1, 1}, none, GridBorder::kClamp), SceneError);
  CHECK_THROWS_AS(make_dense_grid(1, {-5, 1, 1}, none, GridBorder::kClamp), SceneError);
  CHECK_THROWS_AS(make_dense_grid(1, {kMaxGridSide + 1, 1, 1}, none, GridBorder::kClamp), SceneError);
  CHECK_THROWS_AS(make_dense_grid(1, {kMaxGridSide, kMaxGridSide, kMaxGridSide}, none, GridBorder::kClamp), SceneError);
  CHECK_THROWS_AS(make_dense_grid(1, {2, 2, 2}, none, GridBorder::kClamp), SceneError);
  const float one = 1;
  const auto sparse = [&](std::array<int, 3> a, std::array<int, 3> b) {
    VoxelBlocks blocks(1);
    blocks.add_constant(a, {&one, 1});
    blocks.add_constant(b, {&one, 1});
    return make_sparse_grid(blocks);
  };
  CHECK_THROWS_AS(sparse({1, 1, 1}, {1, 1, 1}), SceneError);
  CHECK_THROWS_AS(sparse({0, 0, 0}, {kMaxGridSide / 8, 0, 0}), SceneError);
  CHECK_THROWS_AS(sparse({0, 0, 0}, {4000, 4000, 4000}), SceneError);
  CHECK_THROWS_AS(sparse({0, 0, 0}, {1 << 28, 0, 0}), SceneError);
  CHECK_NOTHROW(sparse({0, 0, 0}, {100, 0, 0}));
}

}  // namespace sheaf::test_brick_grid
