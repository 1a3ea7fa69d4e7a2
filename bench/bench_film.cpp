// The cost of adding a sample to a tile of the film: to its own pixel only, and to every pixel under a pixel filter;
// with sums of squares for the variance of samples, and without them, as for replicates. "per_item" is in seconds.
#include "core/sampling/rng.h"
#include "kernels/film/film.h"

#include <benchmark/benchmark.h>

namespace sheaf {

namespace {

constexpr int kSide = 32;
constexpr std::uint32_t kSamples = 16;

void add_samples(benchmark::State& state, PixelFilter::Kind kind, VarianceUnit unit) {
  PixelFilter description;
  description.kind = kind;
  const FilterWeights weights(description);
  const Film film(kSide, kSide, {0, 0, kSide, kSide}, FilmLayout::beauty(), 0, unit);
  // Make random samples
  SampleBuffer samples;
  samples.resize(kSide * kSide * kSamples, kBeautyChannels, false);
  for (std::uint32_t i = 0; i < kSide * kSide * kSamples; ++i) {
    const auto u = random4<Scalar>(1, i, 0, 0);
    samples.offset(i) = {u.x - 0.5f, u.y - 0.5f};
    for (int c = 0; c < kBeautyChannels; ++c) samples[i][c] = u.z;
  }
  // Measure
  FilmTile tile;
  for (auto _ : state) {
    film.begin(tile, {0, 0, kSide, kSide}, kind == PixelFilter::Kind::kBox ? nullptr : &weights);
    std::size_t sample = 0;
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x, sample += kSamples) tile.add(x, y, samples, sample, kSamples);
    benchmark::DoNotOptimize(tile.row(3, 3));
  }
  state.counters["per_item"] = benchmark::Counter(static_cast<double>(state.iterations()) * kSide * kSide * kSamples,
                                                  benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

using Kind = PixelFilter::Kind;
BENCHMARK_CAPTURE(add_samples, own_pixel, Kind::kBox, VarianceUnit::kSample);
BENCHMARK_CAPTURE(add_samples, own_pixel_replicates, Kind::kBox, VarianceUnit::kReplicate);
BENCHMARK_CAPTURE(add_samples, gaussian, Kind::kGaussian, VarianceUnit::kSample);
BENCHMARK_CAPTURE(add_samples, gaussian_replicates, Kind::kGaussian, VarianceUnit::kReplicate);
BENCHMARK_CAPTURE(add_samples, lanczos_replicates, Kind::kLanczos, VarianceUnit::kReplicate);

}  // namespace

}  // namespace sheaf
