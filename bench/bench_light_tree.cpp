// The cost per item of sampling a light from a light tree and of its probability, by the number of lights. Runs one
// path at a time and in registers, at random points among the lights. "per_item" is in seconds; "per_level" divides it
// by the mean depth of the sampled lights. Also the cost of building the tree.
#include "core/sampling/rng.h"
#include "core/sampling/warp.h"
#include "kernels/lights/light_tree.h"

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <bit>
#include <string>
#include <vector>

namespace sheaf {

namespace {

constexpr int kItems = 4096;

Random4<Scalar> numbers(std::uint32_t stream, std::uint32_t i) { return random4<Scalar>(stream, i, 0, 0); }

/// Small flat lights at random positions in a room.
std::vector<LightBounds> room_lights(std::uint32_t count) {
  std::vector<LightBounds> lights(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    const auto u = numbers(1, i), v = numbers(2, i);
    const Vec3f p{10 * u.x, 10 * u.y, 3 * u.z}, half{0.01f, 0.01f, 0.01f};
    lights[i].lower = p - half;
    lights[i].upper = p + half;
    lights[i].axis = square_to_sphere<Scalar>(v.x, v.y);
    lights[i].cos_theta_o = i % 2 == 0 ? 1.0f : -1.0f;
    lights[i].power = 0.1f + v.z;
  }
  return lights;
}

/// Columns of points, normals, random numbers and results.
struct Items {
  alignas(kSimdAlignment) float p[3][kItems], n[3][kItems], u[kItems], out[kItems];
  alignas(kSimdAlignment) std::uint32_t light[kItems];

  explicit Items(std::uint32_t light_count) {
    for (std::uint32_t i = 0; i < kItems; ++i) {
      const auto a = numbers(3, i), b = numbers(4, i);
      const Vec3f normal = square_to_sphere<Scalar>(b.x, b.y);
      p[0][i] = 10 * a.x;
      p[1][i] = 10 * a.y;
      p[2][i] = 3 * a.z;
      n[0][i] = normal.x;
      n[1][i] = normal.y;
      n[2][i] = normal.z;
      u[i] = a.w;
      light[i] = static_cast<std::uint32_t>(b.w * static_cast<float>(light_count));
    }
  }
};

template <class L> Vec3<L> load_vector(const float (&columns)[3][kItems], int i) {
  Vec3<L> v;
  load(columns[0] + i, v.x);
  load(columns[1] + i, v.y);
  load(columns[2] + i, v.z);
  return v;
}

int depth_of(const LightTree& tree, std::uint32_t light) {
  int depth = 0;
  for (std::uint32_t position = 0; (position & kLightLeaf) == 0; ++depth)
    position = light_tree_child(tree.nodes[position], position, tree.trails[light] >> 2 * depth & 3u);
  return depth;
}

void report(benchmark::State& state, const LightTree& tree, const std::uint32_t* lights) {
  double levels = 0;
  for (int i = 0; i < kItems; ++i) levels += depth_of(tree, lights[i]);
  const auto inverse = benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert;
  state.SetItemsProcessed(state.iterations() * kItems);
  state.counters["per_item"] = benchmark::Counter(kItems, inverse);
  state.counters["per_level"] = benchmark::Counter(levels, inverse);
  state.counters["depth"] = tree.depth;
}

template <class L> void sample(benchmark::State& state, std::uint32_t count) {
  const LightTree tree = build_light_tree(room_lights(count));
  Items items(count);
  for (auto _ : state) {
    for (int i = 0; i < kItems; i += L::width) {
      Float<L> u;
      load(items.u + i, u);
      const auto choice =
          sample_light_tree<L>(tree.view(), load_vector<L>(items.p, i), load_vector<L>(items.n, i), Mask<L>(true), u);
      store(items.out + i, choice.probability);
      store(items.light + i, choice.light);
    }
    benchmark::ClobberMemory();
  }
  report(state, tree, items.light);
}

/// Many candidates for each point, as for resampling. They share the upper levels of the tree and are traversed in
/// pairs. The cost is per candidate.
template <class L> void candidates(benchmark::State& state, std::uint32_t count) {
  constexpr int kCandidates = 32;
  const LightTree tree = build_light_tree(room_lights(count));
  Items items(count);
  const LightTreeView view = tree.view();
  for (auto _ : state) {
    for (int i = 0; i < kItems / kCandidates; i += L::width) {
      const Vec3<L> p = load_vector<L>(items.p, i), n = load_vector<L>(items.n, i);
      const auto cut = light_tree_cut<L>(view, p, n, Mask<L>(true));
      for (int k = i * kCandidates; k < (i + L::width) * kCandidates; k += 2 * L::width) {
        LightTreeTraversal<L> walks[2];
        for (int j = 0; j < 2; ++j) {
          Float<L> u;
          load(items.u + k + j * L::width, u);
          walks[j] = begin_light_traversal<L>(view, cut, p, n, Mask<L>(true), u);
        }
        LightTreeSample<L> choices[2];
        finish_light_traversals<L>(view, walks, choices);
        for (int j = 0; j < 2; ++j) {
          store(items.out + k + j * L::width, choices[j].probability);
          store(items.light + k + j * L::width, choices[j].light);
        }
      }
    }
    benchmark::ClobberMemory();
  }
  report(state, tree, items.light);
}

template <class L> void probability(benchmark::State& state, std::uint32_t count) {
  const LightTree tree = build_light_tree(room_lights(count));
  Items items(count);
  for (auto _ : state) {
    for (int i = 0; i < kItems; i += L::width) {
      Uint<L> light;
      load(items.light + i, light);
      const Vec3<L> p = load_vector<L>(items.p, i), n = load_vector<L>(items.n, i);
      store(items.out + i, light_tree_probability<L>(tree.view(), p, n, Mask<L>(true), light, Mask<L>(true)));
    }
    benchmark::ClobberMemory();
  }
  report(state, tree, items.light);
}

void build(benchmark::State& state, std::uint32_t count) {
  const std::vector<LightBounds> lights = room_lights(count);
  for (auto _ : state) benchmark::DoNotOptimize(build_light_tree(lights).nodes.data());
  state.SetItemsProcessed(state.iterations() * count);
}

[[maybe_unused]] const bool registered = [] {
  const auto add = [](const std::string& name, auto&& f) { return benchmark::RegisterBenchmark(name.c_str(), f); };
  for (const std::uint32_t count : {10u, 100u, 1000u, 100000u}) {
    const std::string lights = fmt::format("/lights:{}", count);
    add(fmt::format("light_tree/sample{}/scalar", lights), [=](benchmark::State& s) { sample<Scalar>(s, count); });
    add(fmt::format("light_tree/sample{}/wide", lights), [=](benchmark::State& s) { sample<Wide>(s, count); });
    add(fmt::format("light_tree/candidates{}/scalar", lights),
        [=](benchmark::State& s) { candidates<Scalar>(s, count); });
    add(fmt::format("light_tree/candidates{}/wide", lights), [=](benchmark::State& s) { candidates<Wide>(s, count); });
    add(fmt::format("light_tree/probability{}/scalar", lights),
        [=](benchmark::State& s) { probability<Scalar>(s, count); });
    add(fmt::format("light_tree/probability{}/wide", lights),
        [=](benchmark::State& s) { probability<Wide>(s, count); });
  }
  for (const std::uint32_t count : {1000u, 100000u})
    add(fmt::format("light_tree/build/lights:{}", count), [=](benchmark::State& s) {
      build(s, count);
    })->Unit(benchmark::kMillisecond);
  return true;
}();

}  // namespace

}  // namespace sheaf
