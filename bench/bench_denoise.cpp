// Non-local means for an image of 1280 x 720 pixels, with two half buffers and three features, and without. "cpu" is
// the CPU time of all threads in seconds.
#include "core/sampling/rng.h"
#include "kernels/denoise/denoise.h"

#include <benchmark/benchmark.h>

#include <ctime>

namespace sheaf {

namespace {

Image noisy_image(int width, int height, bool complete) {
  std::vector<std::string> names = {"R", "G", "B", "variance.R", "variance.G", "variance.B"};
  if (complete)
    names.insert(names.end(),
                 {"half.R", "half.G", "half.B", "albedo.R", "albedo.G", "albedo.B", "N.X", "N.Y", "N.Z", "Z"});
  Image image(width, height, names);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const auto u = random4<Scalar>(1, static_cast<std::uint32_t>(y * width + x), 0, 0);
      for (int c = 0; c < static_cast<int>(names.size()); ++c) image.at(x, y, c) = 0.5f + 0.1f * u.x;
      for (int c = 3; c < 6; ++c) image.at(x, y, c) = 0.001f;
    }
  return image;
}

void denoise_image(benchmark::State& state, bool complete) {
  const Image image = noisy_image(1280, 720, complete);
  const std::clock_t start = std::clock();
  for (auto _ : state) benchmark::DoNotOptimize(denoise(image, Denoiser::kNlMeans));
  state.counters["cpu"] = benchmark::Counter(static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC,
                                             benchmark::Counter::kAvgIterations);
}

BENCHMARK_CAPTURE(denoise_image, halves_and_features, true)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(denoise_image, without_features, false)->Unit(benchmark::kMillisecond);

}  // namespace

}  // namespace sheaf
