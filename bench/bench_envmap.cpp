// The cost of environment maps per item, by size and content of the map: sampling a direction with its radiance, and
// looking one up. In `sky` most directions go to a sun. In `noise` they go to all of the map, so each lookup reads from
// memory. "per_item" is in seconds. `numbers` is the cost of only the random numbers.
#include "core/sampling/rng.h"
#include "core/sampling/warp.h"
#include "kernels/lights/envmap.h"
#include "scene/lights/make_envmap.h"

#include <benchmark/benchmark.h>

#include <cmath>
#include <cstdlib>
#include <string>

namespace sheaf {

namespace {

constexpr std::uint32_t kItems = 1 << 14;

float sky_brightness(double u, double v) {
  const double across = (u - 0.3) * 2 * std::sin(3.14159265 * v), down = v - 0.3;
  const double sun = across * across + down * down < 1e-5 ? 1e4 : 0;
  return static_cast<float>(v < 0.5 ? 0.2 + v + sun : 0.1);
}

/// Keeps one map at a time.
const Envmap& map_of(std::uint32_t width, bool sky) {
  static Envmap map;
  static bool map_is_sky = false;
  if (map.width == width && map_is_sky == sky) return map;
  EnvmapImage image{width, width / 2, std::vector<float>(std::size_t{3} * width * (width / 2))};
  for (std::uint32_t i = 0; 3 * std::size_t{i} < image.rgb.size(); ++i) {
    const std::uint32_t column = i % width, row = i / width, height = width / 2;
    const double u = (column + 0.5) / width, v = (row + 0.5) / height;
    const float noise = 0.5f + static_cast<float>((i * 2654435761u) >> 8) * 0x1p-24f;
    const float value = sky ? sky_brightness(u, v) * (0.9f + 0.1f * noise) : noise;
    for (std::size_t c = 0; c < 3; ++c) image.rgb[3 * std::size_t{i} + c] = value;
  }
  map = {};
  map = make_envmap(image, 1, false);
  map_is_sky = sky;
  return map;
}

/// Runs f(random numbers) -> float over kItems items, with new numbers in each iteration.
template <class L, class F> void run(benchmark::State& state, F&& f) {
  alignas(kSimdAlignment) static float out[kItems];
  float* seen = out;  // the compiler must assume that others read it
  benchmark::DoNotOptimize(seen);
  std::uint32_t round = 0;
  for (auto _ : state) {
    for (std::uint32_t i = 0; i < kItems; i += L::width)
      store(out + i, f(random4<L>(round, Uint<L>(i) + L::index(), Uint<L>(0u), Uint<L>(0u))));
    ++round;
    benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(state.iterations() * kItems);
  state.counters["per_item"] =
      benchmark::Counter(kItems, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

template <class L> void numbers(benchmark::State& state) {
  run<L>(state, [](const Random4<L>& u) { return u.x + u.y; });
}

template <class L> void sample(benchmark::State& state, std::uint32_t width, bool sky) {
  const EnvmapView map = map_of(width, sky).view();
  run<L>(state, [&](const Random4<L>& u) {
    const auto s = sample_envmap<L>(map, u.x, u.y);
    return s.radiance.c0 + s.radiance.c1 + s.radiance.c2 + s.pdf_solid_angle + s.direction.x + s.direction.y +
           s.direction.z;
  });
}

template <class L> void sample_ahead(benchmark::State& state, std::uint32_t width, bool sky) {
  const EnvmapView map = map_of(width, sky).view();
  EnvmapDraw<L> nodes_ahead = draw_envmap_row<L>(map, Float<L>(0.5f));
  draw_envmap_column<L>(map, Float<L>(0.5f), nodes_ahead);
  EnvmapDraw<L> column_ahead = nodes_ahead;
  Float<L> u_ahead(0.5f);
  run<L>(state, [&](const Random4<L>& u) {
    const EnvmapDraw<L> row = draw_envmap_row<L>(map, u.y);
    prefetch_envmap_column<L>(map, u.x, row);
    draw_envmap_column<L>(map, u_ahead, column_ahead);
    prefetch_envmap_nodes<L>(map, column_ahead);
    const auto s = sample_envmap<L>(map, nodes_ahead);
    nodes_ahead = column_ahead;
    column_ahead = row;
    u_ahead = u.x;
    return s.radiance.c0 + s.radiance.c1 + s.radiance.c2 + s.pdf_solid_angle + s.direction.x + s.direction.y +
           s.direction.z;
  });
}

template <class L> void lookup(benchmark::State& state, std::uint32_t width, bool sky) {
  const EnvmapView map = map_of(width, sky).view();
  run<L>(state, [&](const Random4<L>& u) {
    const auto value = lookup_envmap<L>(map, square_to_sphere<L>(u.x, u.y));
    return value.radiance.c0 + value.radiance.c1 + value.radiance.c2 + value.pdf_solid_angle;
  });
}

template <class L> void add_map(std::uint32_t width, bool sky, const std::string& lane) {
  const std::string map = fmt::format("{}/width:{}/{}", sky ? "/sky" : "/noise", width, lane);
  benchmark::RegisterBenchmark(("envmap/sample" + map).c_str(), sample<L>, width, sky);
  benchmark::RegisterBenchmark(("envmap/sample_ahead" + map).c_str(), sample_ahead<L>, width, sky);
  benchmark::RegisterBenchmark(("envmap/lookup" + map).c_str(), lookup<L>, width, sky);
}

[[maybe_unused]] const bool registered = [] {
  benchmark::RegisterBenchmark("envmap/numbers/scalar", numbers<Scalar>);
  benchmark::RegisterBenchmark("envmap/numbers/wide", numbers<Wide>);
  for (const std::uint32_t width : {512u, 4096u, 8192u})
    for (const bool sky : {true, false}) {
      if (width > 4096 && std::getenv("SHEAF_BENCH_LARGE") == nullptr) continue;
      add_map<Scalar>(width, sky, "scalar");
      add_map<Wide>(width, sky, "wide");
    }
  return true;
}();

}  // namespace

}  // namespace sheaf
