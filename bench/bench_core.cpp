// The cost of the primitives of core per item. Every benchmark reports "per_item" in seconds (1.5n is 1.5 nanoseconds)
// for as many items as a wave has, which fit the L1 or L2 cache.
#include "core/color/spectrum.h"
#include "core/math/frame.h"
#include "core/sampling/alias_table.h"
#include "core/sampling/sampler.h"
#include "core/sampling/warp.h"
#include "kernels/wave/bucket_sort.h"
#include "kernels/wave/slot_table.h"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <numeric>
#include <vector>

namespace sheaf {

namespace {

constexpr int kItems = 1024;

void report(benchmark::State& state, int items = kItems) {
  state.SetItemsProcessed(state.iterations() * items);
  state.counters["per_item"] =
      benchmark::Counter(items, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

float uniform(int i, std::uint32_t stream) { return random4<Scalar>(stream, static_cast<std::uint32_t>(i), 0, 0).x; }

/// Slots 0 .. count - 1 in random order, as after sorting.
std::vector<Slot> shuffled_slots(int count) {
  std::vector<Slot> slots(static_cast<std::size_t>(count));
  std::iota(slots.begin(), slots.end(), Slot{0});
  std::sort(slots.begin(), slots.end(), [](Slot a, Slot b) { return uniform(a, 1) < uniform(b, 1); });
  return slots;
}

/// Eight words per path: half a cache line.
template <class L> struct Row {
  Vec3<L> origin, direction;
  typename L::Float t_max;
  typename L::Uint flags;
  static constexpr auto fields(auto& s) { return std::tie(s.origin, s.direction, s.t_max, s.flags); }
};

/// Sixteen words per path: a cache line.
template <class L> struct LongRow {
  Row<L> first, second;
  static constexpr auto fields(auto& s) { return std::tie(s.first, s.second); }
};

/// Two uniform numbers per item, in columns, and columns to write results to.
struct Numbers {
  Arena arena{8 * (kItems + 64) * sizeof(float)};
  float *u, *v, *out[4];
  Numbers() {
    for (float** column : {&u, &v, &out[0], &out[1], &out[2], &out[3]}) *column = arena.take<float>(kItems + 16);
    for (int i = 0; i < kItems; ++i) u[i] = uniform(i, 2), v[i] = uniform(i, 3);
  }
};

/// Prevents the compiler from vectorizing a scalar loop, so that scalar and wide code can be compared.
template <class L> SHEAF_INLINE void stay_scalar() {
  if constexpr (L::width == 1) benchmark::ClobberMemory();
}

/// Runs f(u, v), which returns a record, over all items.
template <class L, class F> void run_pairs(benchmark::State& state, F&& f) {
  Numbers n;
  for (auto _ : state) {
    for (int i = 0; i < kItems; i += L::width) {
      Float<L> u, v;
      load(n.u + i, u);
      load(n.v + i, v);
      stay_scalar<L>();
      const auto result = f(u, v);
      std::apply(
          [&](const auto&... field) {
            int k = 0;
            (store(n.out[k++] + i, field), ...);
          },
          decltype(result)::fields(result));
    }
    benchmark::ClobberMemory();
  }
  report(state);
}

template <class L> struct Pair {
  typename L::Float a, b;
  static constexpr auto fields(auto& s) { return std::tie(s.a, s.b); }
};

}  // namespace

// ---- sorting, transposing, pushing ----------------------------------------------------------------------------------
static void bucket_sort_slots(benchmark::State& state) {
  const int count = static_cast<int>(state.range(0)), buckets = static_cast<int>(state.range(1));
  const std::vector<Slot> slots = shuffled_slots(count);
  std::vector<Slot> sorted(slots.size());
  std::vector<std::uint8_t> keys(slots.size());
  for (int i = 0; i < count; ++i)
    keys[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(uniform(i, 4) * static_cast<float>(buckets));
  std::vector<int> begin(kMaxBuckets + 1);
  for (auto _ : state) {
    bucket_sort(slots.data(), keys.data(), count, buckets, sorted.data(), begin.data());
    benchmark::ClobberMemory();
  }
  report(state, count);
}
BENCHMARK(bucket_sort_slots)
    ->ArgNames({"items", "buckets"})
    ->Args({1024, 4})
    ->Args({1024, 16})
    ->Args({1024, 256})
    ->Args({4096, 16});

template <class L, template <class> class Record> static void groups_gather(benchmark::State& state) {
  Arena arena(SlotTable<Record>::bytes(kItems));
  SlotTable<Record> groups;
  groups.bind(arena, kItems);
  const std::vector<Slot> slots = shuffled_slots(kItems);
  for (auto _ : state)
    for (int i = 0; i < kItems; i += L::width) {
      Record<L> row = groups.template gather<L>(slots.data() + i);
      std::apply([](auto&... leaf) { (benchmark::DoNotOptimize(leaf), ...); }, leaves(row));
    }
  report(state);
}
BENCHMARK(groups_gather<Scalar, Row>)->Name("groups_gather/words:8/scalar");
BENCHMARK(groups_gather<Wide, Row>)->Name("groups_gather/words:8/wide");
BENCHMARK(groups_gather<Wide, LongRow>)->Name("groups_gather/words:16/wide");

/// The alternative to SlotTable: one gather instruction per column.
template <template <class> class Record> static void column_gather(benchmark::State& state) {
  Arena arena(Soa<Record>::bytes(kItems));
  Soa<Record> columns;
  columns.bind(arena, kItems);
  const std::vector<Slot> slots = shuffled_slots(kItems);
  for (auto _ : state)
    for (int i = 0; i < kItems; i += kWidth) {
      alignas(kSimdAlignment) std::uint32_t lanes[kWidth];
      for (int lane = 0; lane < kWidth; ++lane) lanes[lane] = slots[static_cast<std::size_t>(i + lane)];
      WideUint index;
      load(lanes, index);
      std::apply([index](auto*... column) { (benchmark::DoNotOptimize(gather(column, index)), ...); },
                 leaves(columns.columns()));
    }
  report(state);
}
BENCHMARK(column_gather<Row>)->Name("column_gather/words:8/wide");
BENCHMARK(column_gather<LongRow>)->Name("column_gather/words:16/wide");

template <class L, template <class> class Record> static void groups_scatter(benchmark::State& state) {
  Arena arena(SlotTable<Record>::bytes(kItems));
  SlotTable<Record> groups;
  groups.bind(arena, kItems);
  const std::vector<Slot> slots = shuffled_slots(kItems);
  Record<L> row{};
  for (auto _ : state) {
    for (int i = 0; i < kItems; i += L::width) {
      std::apply([](auto&... leaf) { (benchmark::DoNotOptimize(leaf), ...); }, leaves(row));
      groups.template scatter<L>(slots.data() + i, L::width, row);
    }
    benchmark::ClobberMemory();
  }
  report(state);
}
BENCHMARK(groups_scatter<Scalar, Row>)->Name("groups_scatter/words:8/scalar");
BENCHMARK(groups_scatter<Wide, Row>)->Name("groups_scatter/words:8/wide");
BENCHMARK(groups_scatter<Wide, LongRow>)->Name("groups_scatter/words:16/wide");

/// Reads rows in order and keeps the given percentage of them.
template <class L> static void soa_compress(benchmark::State& state) {
  Arena arena(2 * Soa<Row>::bytes(kItems));
  Soa<Row> source, target;
  source.bind(arena, kItems);
  target.bind(arena, kItems);
  for (int i = 0; i < kItems; ++i) source.columns().t_max[i] = uniform(i, 5);
  const Float<L> fraction(static_cast<float>(state.range(0)) / 100.0f);
  for (auto _ : state) {
    int kept = 0;
    for (int i = 0; i < kItems; i += L::width) {
      const Row<L> row = source.load<L>(i);
      kept += target.compress<L>(kept, row, row.t_max < fraction);
    }
    benchmark::DoNotOptimize(kept);
    benchmark::ClobberMemory();
  }
  report(state);
}
BENCHMARK(soa_compress<Scalar>)->Name("soa_compress/words:8/scalar")->ArgName("percent")->Arg(10)->Arg(50)->Arg(90);
BENCHMARK(soa_compress<Wide>)->Name("soa_compress/words:8/wide")->ArgName("percent")->Arg(10)->Arg(50)->Arg(90);

static void slot_push(benchmark::State& state) {
  Arena arena(SlotList::bytes(kItems));
  SlotList list;
  list.bind(arena, kItems);
  const std::vector<Slot> slots = shuffled_slots(kItems);
  std::vector<std::uint32_t> masks;
  for (int i = 0; i < kItems; i += kWidth) {
    std::uint32_t bits = 0;
    for (int lane = 0; lane < kWidth; ++lane)
      if (uniform(i + lane, 6) * 100.0f < static_cast<float>(state.range(0))) bits |= 1u << lane;
    masks.push_back(bits);
  }
  for (auto _ : state) {
    list.clear();
    for (int i = 0; i < kItems; i += kWidth) list.push(slots.data() + i, masks[static_cast<std::size_t>(i / kWidth)]);
    benchmark::ClobberMemory();
  }
  report(state);
}
BENCHMARK(slot_push)->ArgName("percent")->Arg(10)->Arg(50)->Arg(90);

// ---- random numbers and warps ---------------------------------------------------------------------------------------
template <class L, SamplerKind kKind> static void random_numbers(benchmark::State& state) {
  Numbers n;
  const SamplerView sampler = make_sampler(kKind, 7, 64);
  std::uint32_t sample = 0;
  for (auto _ : state) {
    for (int i = 0; i < kItems; i += L::width) {
      const Uint<L> pixel = Uint<L>(static_cast<std::uint32_t>(i)) + L::index();
      const Random4<L> r = draw<L>(sampler, pixel, Uint<L>(sample % 64), Uint<L>(3u), SampleBlock::kScatter);
      store(n.out[0] + i, r.x);
      store(n.out[1] + i, r.y);
      store(n.out[2] + i, r.z);
      store(n.out[3] + i, r.w);
      stay_scalar<L>();
    }
    ++sample;
    benchmark::ClobberMemory();
  }
  report(state);
}

template <class L> static void warp_sincos_2pi(benchmark::State& state) {
  run_pairs<L>(state, [](Float<L> u, Float<L>) {
    const SinCos<L> sc = sincos_2pi<L>(u);
    return Pair<L>{sc.sin, sc.cos};
  });
}
template <class L> static void warp_disk(benchmark::State& state) {
  run_pairs<L>(state, [](Float<L> u, Float<L> v) { return square_to_disk<L>(u, v); });
}
template <class L> static void warp_cosine_hemisphere(benchmark::State& state) {
  run_pairs<L>(state, [](Float<L> u, Float<L> v) { return square_to_cosine_hemisphere<L>(u, v); });
}
template <class L> static void warp_sphere(benchmark::State& state) {
  run_pairs<L>(state, [](Float<L> u, Float<L> v) { return square_to_sphere<L>(u, v); });
}
template <class L> static void warp_cone(benchmark::State& state) {
  run_pairs<L>(state, [](Float<L> u, Float<L> v) { return square_to_cone<L>(u, v, Float<L>(0.1f)); });
}
template <class L> static void warp_triangle(benchmark::State& state) {
  run_pairs<L>(state, [](Float<L> u, Float<L> v) { return square_to_triangle<L>(u, v); });
}
template <class L> static void frame_from_normal(benchmark::State& state) {
  run_pairs<L>(state, [](Float<L> u, Float<L> v) {
    const Vec3<L> w = square_to_cosine_hemisphere<L>(u, v);
    return Frame<L>::from_normal(w).to_world(w);
  });
}

// ---- distributions --------------------------------------------------------------------------------------------------
static std::vector<float> bench_weights(std::int64_t count) {
  std::vector<float> weights;
  for (std::int64_t i = 0; i < count; ++i) weights.push_back(uniform(static_cast<int>(i), 8));
  return weights;
}
template <class L> static void alias_sample(benchmark::State& state) {
  const auto table = build_alias_table(bench_weights(state.range(0)));
  const Uint<L> count(static_cast<std::uint32_t>(table.size()));
  run_pairs<L>(state, [&](Float<L> u, Float<L>) {
    const AliasSample<L> s = sample_alias<L>(table.data(), Uint<L>(0u), count, u);
    return Vec3<L>{bits_float(s.index), s.pdf, s.remapped};
  });
}

namespace {

using Function = void (*)(benchmark::State&);

/// Registers the scalar and the wide version of a benchmark under one name.
bool both(const std::string& name, Function scalar, Function wide, const std::vector<std::int64_t>& sizes = {}) {
  const std::pair<const char*, Function> versions[] = {{"/scalar", scalar}, {"/wide", wide}};
  for (const auto& [suffix, function] : versions) {
    auto* registered = benchmark::RegisterBenchmark((name + suffix).c_str(), function);
    for (const std::int64_t size : sizes) registered->ArgName("size")->Arg(size);
  }
  return true;
}

template <SamplerKind kKind> bool sampler(const std::string& name) {
  return both("draw/" + name, random_numbers<Scalar, kKind>, random_numbers<Wide, kKind>);
}

[[maybe_unused]] const bool registered =
    sampler<SamplerKind::kIndependent>("independent") && sampler<SamplerKind::kStratified>("stratified") &&
    sampler<SamplerKind::kMultijitter>("multijitter") && sampler<SamplerKind::kSobol>("sobol") &&
    both("sincos_2pi", warp_sincos_2pi<Scalar>, warp_sincos_2pi<Wide>) &&
    both("square_to_disk", warp_disk<Scalar>, warp_disk<Wide>) &&
    both("square_to_cosine_hemisphere", warp_cosine_hemisphere<Scalar>, warp_cosine_hemisphere<Wide>) &&
    both("square_to_sphere", warp_sphere<Scalar>, warp_sphere<Wide>) &&
    both("square_to_cone", warp_cone<Scalar>, warp_cone<Wide>) &&
    both("square_to_triangle", warp_triangle<Scalar>, warp_triangle<Wide>) &&
    both("hemisphere_in_frame", frame_from_normal<Scalar>, frame_from_normal<Wide>) &&
    both("sample_alias", alias_sample<Scalar>, alias_sample<Wide>, {8, 4096, 1 << 18});

}  // namespace

}  // namespace sheaf
