// The cost of the primitives of spectral mode per path, that is per four wavelengths, in registers and one path at a
// time: sampling wavelengths, evaluating rows of each kind, upsampling texels, environment maps, and the sensor. Also
// the cost of computing the upsampling table.
#include "core/color/spectral_sensor.h"
#include "core/color/uplift.h"
#include "core/sampling/rng.h"
#include "kernels/lights/envmap.h"
#include "scene/data/glasses.h"
#include "scene/lights/make_envmap.h"
#include "scene/spectra/spectrum_set.h"

#include <benchmark/benchmark.h>

#include <string>

namespace sheaf {

namespace {

constexpr int kItems = 1024;

/// Columns of random numbers for wavelengths, colors, rows, and results.
struct Paths {
  alignas(kSimdAlignment) float u[kItems], rgb[3][kItems], out[4][kItems];
  alignas(kSimdAlignment) std::uint32_t row[kItems];

  explicit Paths(std::uint32_t rows) {
    for (std::uint32_t i = 0; i < kItems; ++i) {
      const auto r = random4<Scalar>(1, i, 0, 0);
      u[i] = random4<Scalar>(2, i, 0, 0).x;
      rgb[0][i] = r.x, rgb[1][i] = r.y, rgb[2][i] = r.z;
      row[i] = static_cast<std::uint32_t>(r.w * static_cast<float>(rows));
    }
  }
  template <class L> Vec3<L> color(int i) const {
    Vec3<L> c;
    load(rgb[0] + i, c.x), load(rgb[1] + i, c.y), load(rgb[2] + i, c.z);
    return c;
  }
};

/// Runs f(paths, index of the first item, wavelengths) -> Spectrum over all items. Includes sampling the wavelengths.
template <class L, class F> void run(benchmark::State& state, std::uint32_t rows, F&& f) {
  Paths paths(rows);
  for (auto _ : state) {
    for (int i = 0; i < kItems; i += L::width) {
      Float<L> u;
      load(paths.u + i, u);
      if constexpr (L::width == 1) benchmark::ClobberMemory();
      const Spectrum<L> s = f(paths, i, sample_wavelengths<L>(u));
      store(paths.out[0] + i, s.c0), store(paths.out[1] + i, s.c1);
      store(paths.out[2] + i, s.c2), store(paths.out[3] + i, s.c3);
    }
    benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(state.iterations() * kItems);
  state.counters["per_item"] =
      benchmark::Counter(kItems, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

template <class L> void wavelengths(benchmark::State& state) {
  run<L>(state, 1, [](const Paths&, int, const Wavelengths<L>& w) { return w.lambda * w.pdf; });
}

template <class L> void sensor(benchmark::State& state) {
  run<L>(state, 1, [](const Paths& paths, int i, const Wavelengths<L>& w) {
    const Vec3<L> c = paths.color<L>(i);
    const Vec3<L> rgb = radiance_to_rgb<L>(SensorCurves::get(), w, {c.x, c.y, c.z, c.x});
    return Spectrum<L>(rgb.x, rgb.y, rgb.z, rgb.x);
  });
}

template <class L> void uplift(benchmark::State& state) {
  const UpliftTable& table = UpliftTable::get();
  run<L>(state, 1, [&](const Paths& paths, int i, const Wavelengths<L>& w) {
    return evaluate(uplift_reflectance<L>(table, paths.color<L>(i)), w.lambda);
  });
}

template <class L> void formula(benchmark::State& state) {
  const Dispersion& glass = *find_dispersion("bk7");
  run<L>(state, 1, [&](const Paths&, int, const Wavelengths<L>& w) {
    return Spectrum<L>(ior<L>(glass, w.lambda.c0), ior<L>(glass, w.lambda.c1), ior<L>(glass, w.lambda.c2),
                       ior<L>(glass, w.lambda.c3));
  });
}

/// 64 rows of one kind in random order.
template <class L> void rows(benchmark::State& state, SpectrumUse use, bool tables) {
  SpectrumSet set;
  std::vector<SpectrumRow> list;
  for (std::uint32_t k = 0; k < 64; ++k) {
    const auto r = random4<Scalar>(9, k, 0, 0);
    if (tables)
      list.push_back(set.row({SpectrumDescription::Table{{400, 500, 700}, {r.x, r.y, r.z}}}, use));
    else
      list.push_back(set.row(SpectrumDescription::rgb(r.x, r.y, r.z), use));
  }
  run<L>(state, 64, [&](const Paths& paths, int i, const Wavelengths<L>& w) {
    Uint<L> index;
    load(paths.row + i, index);
    return evaluate<L>(list.data(), index, set.view(), w.lambda);
  });
}

/// A map of random colors.
Envmap random_map(std::uint32_t width, std::uint32_t height) {
  EnvmapImage image{width, height, std::vector<float>(3 * std::size_t{width} * height)};
  for (std::uint32_t i = 0; i < image.rgb.size(); ++i) image.rgb[i] = random4<Scalar>(7, i, 0, 0).x;
  return make_envmap(image, 1, false);
}

/// Lookups in random directions, in a map of 2 MB of colors.
template <class L, ColorMode kMode> void environment(benchmark::State& state) {
  Envmap map = random_map(512, 256);
  uplift_nodes(map);
  const EnvmapView view = map.view();
  run<L>(state, 1, [&](const Paths& paths, int i, const Wavelengths<L>& w) {
    const Vec3<L> c = paths.color<L>(i);
    const auto value = lookup_envmap<L, kMode>(view, square_to_sphere<L>(c.x, c.y), w.lambda);
    return value.radiance * value.pdf_solid_angle;
  });
}

void uplift_map(benchmark::State& state) {
  Envmap map = random_map(2048, 1024);
  for (auto _ : state) {
    uplift_nodes(map);
    benchmark::DoNotOptimize(map.spectra.data());
  }
  state.counters["per_item"] =
      benchmark::Counter(2048 * 1024, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
BENCHMARK(uplift_map)->Name("spectra/uplift_map")->Unit(benchmark::kMillisecond)->UseRealTime();

void make_table(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(UpliftTable().nodes.data());
}
BENCHMARK(make_table)->Name("spectra/make_uplift_table")->Unit(benchmark::kMillisecond)->UseRealTime();

void fit_one(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(fit_reflectance({0.8f, 0.3f, 0.1f}));
}
BENCHMARK(fit_one)->Name("spectra/fit_one_color");

template <class L> void register_lane(const std::string& lane) {
  const auto add = [&](const char* name, auto&& f) {
    benchmark::RegisterBenchmark(fmt::format("spectra/{}/{}", name, lane).c_str(), f);
  };
  add("wavelengths", wavelengths<L>);
  add("sensor", sensor<L>);
  add("uplift_texel", uplift<L>);
  add("environment_rgb", environment<L, ColorMode::kRgb>);
  add("environment_spectral", environment<L, ColorMode::kSpectral>);
  add("ior_formula", formula<L>);
  add("row_reflectance", [](benchmark::State& s) { rows<L>(s, SpectrumUse::kReflectance, false); });
  add("row_emitter", [](benchmark::State& s) { rows<L>(s, SpectrumUse::kIlluminant, false); });
  add("row_table", [](benchmark::State& s) { rows<L>(s, SpectrumUse::kUnbounded, true); });
}

[[maybe_unused]] const bool kRegistered = [] {
  register_lane<Scalar>("scalar");
  register_lane<Wide>("wide");
  return true;
}();

}  // namespace

}  // namespace sheaf
