// The cost of volumes: lookups in brick grids, steps from leaf to leaf of a majorant grid, tracking, and construction
// of majorants. In chains each lookup position depends on the previous value, as in tracking. "per_item" is in seconds.
#include "core/sampling/rng.h"
#include "kernels/media/density_tracking.h"
#include "scene/compile/media/build_brick_grid.h"
#include "scene/compile/media/make_majorants.h"

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <memory>
#include <string>
#include <vector>

namespace sheaf {

namespace {

constexpr int kItems = 4096;

float uniform(std::uint32_t i, std::uint32_t stream) { return random4<Scalar>(stream, i, 0, 0).x; }

void count_items(benchmark::State& state, std::size_t items) {
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(items));
  state.counters["per_item"] = benchmark::Counter(
      static_cast<double>(items), benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

/// A cube of noise, of `side`^3 voxels.
BrickGrid noise_grid(int side, int channels, GridBorder border) {
  const auto n = static_cast<std::size_t>(side);
  if (border != GridBorder::kBackground) {
    std::vector<float> values(n * n * n * static_cast<std::size_t>(channels));
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = uniform(static_cast<std::uint32_t>(i), 1);
    return make_dense_grid(channels, {side, side, side}, values, border);
  }
  VoxelBlocks blocks(channels);
  std::uint32_t i = 0;
  for (int z = 0; z < side / 8; ++z)
    for (int y = 0; y < side / 8; ++y)
      for (int x = 0; x < side / 8; ++x)
        for (float& v : blocks.add({x, y, z})) v = uniform(i++, 1);
  return make_sparse_grid(blocks);
}

struct Case {
  const char* name;
  int channels;
  GridBorder border;
  GridFilter filter;
};
constexpr Case kCases[] = {
    {"density/trilinear", 1, GridBorder::kBackground, GridFilter::kTrilinear},
    {"density/nearest", 1, GridBorder::kBackground, GridFilter::kNearest},
    {"density/trilinear/clamp", 1, GridBorder::kClamp, GridFilter::kTrilinear},
    {"density/trilinear/repeat", 1, GridBorder::kRepeat, GridFilter::kTrilinear},
    {"color/trilinear", 3, GridBorder::kBackground, GridFilter::kTrilinear},
    {"color/trilinear/clamp", 3, GridBorder::kClamp, GridFilter::kTrilinear},
};

/// Lookups anywhere in a cube. `is_chain`: the next position depends on the previous value.
void lookup(benchmark::State& state, const Case& c, int side, bool is_chain) {
  const BrickGrid grid = noise_grid(side, c.channels, c.border);
  const BrickGridRow row = make_brick_grid_row(grid, Transform(), c.filter);
  // Choose random positions
  std::vector<Vec3f> positions(kItems);
  const auto n = static_cast<float>(side - 1);
  for (std::uint32_t i = 0; i < kItems; ++i) positions[i] = Vec3f{uniform(i, 2), uniform(i, 3), uniform(i, 4)} * n;
  const float chain = is_chain ? 1e-10f : 0.0f;
  // Measure the lookups; in a chain, each position depends on the previous value
  const auto run = [&](auto&& look) {
    for (auto _ : state) {
      float sum = 0, last = 0;
      for (const Vec3f& position : positions) {
        const Vec3f p = is_chain ? Vec3f{position.x + last * chain, position.y, position.z} : position;
        last = look(p);
        sum += last;
      }
      benchmark::DoNotOptimize(sum);
    }
  };
  if (c.channels == 1)
    run([&](Vec3f p) { return lookup_grid(row, p); });
  else
    run([&](Vec3f p) { return max_component(lookup_grid_color(row, p)); });
  count_items(state, kItems);
}

/// Rays through a cube of side `n`.
struct Rays {
  std::vector<Vec3f> origins, directions;
  explicit Rays(float n) {
    for (std::uint32_t i = 0; i < 512; ++i) {
      const Vec3f from = Vec3f{uniform(i, 5), uniform(i, 6), -0.5f} * n,
                  to = Vec3f{uniform(i, 7), uniform(i, 8), 1.5f} * n;
      origins.push_back(from);
      directions.push_back(normalize(to - from));
    }
  }
};

/// Rays through a grid of `cells`^3 cells, one at a time. An item is a segment, or with `per_ray` a ray.
void walk(benchmark::State& state, int cells, bool per_ray) {
  const auto count = static_cast<std::size_t>(cells * cells * cells);
  const std::vector<MajorantBounds> bounds(count, MajorantBounds::around(0.0f, 1.0f));
  // Build a majorant grid whose cells are all leaves
  std::vector<std::uint32_t> entries;
  for (std::uint32_t i = 0; i < count; ++i) entries.push_back(i << kMajorantSideBits);
  MajorantGridRow row;
  for (int axis = 0; axis < 3; ++axis) {
    row.world_to_grid[5 * axis] = 1;
    row.cells[axis] = static_cast<std::uint32_t>(cells);
    row.box_max[axis] = static_cast<float>(cells);
  }
  row.entries = entries.data();
  row.bounds = bounds.data();
  const Rays rays(static_cast<float>(cells));
  // Measure traversals
  std::size_t segments = 0;
  for (auto _ : state) {
    segments = 0;
    float sum = 0;
    for (std::size_t i = 0; i < rays.origins.size(); ++i) {
      MajorantWalk steps(row, rays.origins[i], rays.directions[i], 0, kInfinity);
      for (MajorantSegment s; steps.next(s); ++segments) sum += (s.t1 - s.t0) * s.bound;
    }
    benchmark::DoNotOptimize(sum);
  }
  count_items(state, per_ray ? rays.origins.size() : segments);
}

/// Tracking through voxels of noise, one ray or many at a time. An item is a collision. "per_ray": mean number per ray.
template <class L, DensityTracking kPurpose> void tracking(benchmark::State& state, int side) {
  const BrickGrid grid = noise_grid(side, 1, GridBorder::kBackground);
  const float extinction = 4.0f / static_cast<float>(side);
  const MajorantGrid majorants = make_majorant_grid(grid, GridFilter::kTrilinear, {extinction});
  const BrickGridRow density = make_brick_grid_row(grid, Transform(), GridFilter::kTrilinear);
  const MajorantGridRow bounds = make_majorant_grid_row(majorants, grid, Transform(), GridFilter::kTrilinear);
  const Rays rays(static_cast<float>(side - 1));
  const auto rows = std::make_unique<DensityRays>();
  const auto ends = std::make_unique<TrackResults>();
  for (int i = 0; i < kDensityRows; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const float first = (static_cast<float>(i) + 0.5f) / kDensityRows;
    rows->store<Scalar>(i, {rays.origins[k],
                            rays.directions[k],
                            1e6f,
                            extinction,
                            extinction,
                            first,
                            {static_cast<std::uint32_t>(i), 1, 2, 3}});
  }
  for (auto _ : state) track_densities<L, kPurpose>({bounds, density}, *rows, kDensityRows, *ends);
  std::size_t collisions = 0;
  for (int i = 0; i < kDensityRows; ++i) {
    const TrackResult<Scalar> end = ends->load<Scalar>(i);
    collisions += end.nulls + (end.outcome == static_cast<std::uint32_t>(DensityOutcome::kScattered) ? 1u : 0u);
  }
  count_items(state, collisions);
  state.counters["per_ray"] = static_cast<double>(collisions) / kDensityRows;
}

template <class L, DensityTracking kPurpose> auto tracking_of(int side) {
  return [side](benchmark::State& state) { tracking<L, kPurpose>(state, side); };
}

/// Builds majorants; an item is a voxel. "share": their memory over that of the grid.
void make_majorants(benchmark::State& state, int side, float thickness) {
  const BrickGrid grid = noise_grid(side, 1, GridBorder::kBackground);
  std::size_t bytes = 0;
  for (auto _ : state) bytes = make_majorant_grid(grid, GridFilter::kTrilinear, {thickness}).bytes();
  count_items(state, static_cast<std::size_t>(side * side * side));
  state.counters["share"] = static_cast<double>(bytes) / static_cast<double>(grid.bytes());
}

[[maybe_unused]] const bool registered = [] {
  const auto add = [](const std::string& name, auto&& f) {
    benchmark::RegisterBenchmark(name.c_str(), std::forward<decltype(f)>(f));
  };
  for (const Case& c : kCases)
    for (const int side : {32, 56, 256})  // 150 KB, 1 MB and 94 MB of one channel
      for (const bool is_chain : {false, true}) {
        if (c.channels == 3 && side == 256) continue;
        add(fmt::format("volume/{}/side:{}{}", c.name, side, is_chain ? "/chain" : "/free"),
            [&c, side, is_chain](benchmark::State& s) { lookup(s, c, side, is_chain); });
      }
  for (const int cells : {1, 4, 16, 64}) {
    add(fmt::format("volume/majorant_step/cells:{}", cells), [cells](benchmark::State& s) { walk(s, cells, false); });
    add(fmt::format("volume/majorant_ray/cells:{}", cells), [cells](benchmark::State& s) { walk(s, cells, true); });
  }
  for (const int side : {32, 256}) {
    const std::string end = fmt::format("/side:{}", side);
    add("volume/scattering/one" + end, tracking_of<Scalar, DensityTracking::kScattering>(side));
    add("volume/scattering/many" + end, tracking_of<Wide, DensityTracking::kScattering>(side));
    add("volume/transmittance/one" + end, tracking_of<Scalar, DensityTracking::kTransmittance>(side));
    add("volume/transmittance/many" + end, tracking_of<Wide, DensityTracking::kTransmittance>(side));
  }
  for (const float thickness : {0.0f, 0.1f})
    add(fmt::format("volume/make_majorants/thickness:{}", thickness),
        [thickness](benchmark::State& s) { make_majorants(s, 128, thickness); });
  return true;
}();

}  // namespace

}  // namespace sheaf
