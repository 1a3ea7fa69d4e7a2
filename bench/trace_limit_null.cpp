// The null hypothesis: neither waves nor wide registers improve speed. Compares the renderer's own kernels, run path by
// path and one lane at a time, with their normal execution.
#include "bench/trace_limit.h"
#include "core/simd/flush_denormals.h"
#include "kernels/film/camera_task.h"
#include "kernels/film/film_layout.h"
#include "kernels/passes/passes.h"
#include "kernels/stages/stage_list.h"

#include <algorithm>
#include <limits>

namespace sheaf {

namespace {

constexpr int kTileSide = 64, kTileSpp = 4;
/// Maximum number of tiles that are rendered, evenly spaced in the frame.
constexpr std::size_t kMaxTiles = 32;

std::vector<std::vector<PixelSamples>> choose_tiles(const FilmSettings& film) {
  std::vector<PixelRect> all;
  for (int y = 0; y < film.height; y += kTileSide)
    for (int x = 0; x < film.width; x += kTileSide) {
      all.push_back({x, y, std::min(x + kTileSide, film.width), std::min(y + kTileSide, film.height)});
    }
  const std::size_t count = std::min(all.size(), kMaxTiles);
  std::vector<std::vector<PixelSamples>> chosen;
  for (std::size_t i = 0; i < count; ++i)
    chosen.push_back(samples_of(all[i * all.size() / count], {film.width}, 0, kTileSpp));
  return chosen;
}

/// Duration of one call of timestamp() in seconds.
double timestamp_cost() {
  constexpr int kCalls = 1 << 16;
  std::uint64_t shortest = std::numeric_limits<std::uint64_t>::max();
  for (int attempt = 0; attempt < 8; ++attempt) {
    const std::uint64_t start = timestamp();
    std::uint64_t last = start;
    for (int i = 0; i < kCalls; ++i) last = timestamp();
    shortest = std::min(shortest, last - start);
  }
  return static_cast<double>(shortest) * seconds_per_tick() / kCalls;
}

double stamps(const Stats& stats) {
  std::uint64_t pairs = stats[stage_named("intersect")].batches + stats[stage_named("shadow")].batches +
                        stats[stage_named("transmittance")].batches;
  for (const StageStats& stage : stats.stages) pairs += stage.calls;
  return 2.0 * static_cast<double>(pairs);
}

/// One way to run the kernels, and its measurements.
struct Contender {
  const char* lane;
  void (*run)(const StageContext&, Wave&);
  int wave_size;
  std::vector<double> total, trace, stamps;  ///< nanoseconds per ray, one value per round
};

void run_round(const Scene& scene, const std::vector<std::vector<PixelSamples>>& tiles, double stamp_cost,
               Contender& contender) {
  const FlushDenormals flush;
  CameraTask task;
  const StageContext context(scene, task);
  Wave wave(contender.wave_size, WaveNeeds::of(context));
  const Stopwatch watch;
  for (const std::vector<PixelSamples>& tile : tiles) {
    task.begin(tile, {scene.film().width}, kBeautyChannels);
    contender.run(context, wave);
  }
  const Duration elapsed = watch.elapsed();
  const double ns = 1e9 / static_cast<double>(wave.stats.rays.total());
  const double trace_fraction = static_cast<double>(wave.stats.trace_ticks) * seconds_per_tick() / elapsed.seconds;
  contender.total.push_back(elapsed.cpu_seconds * ns);
  contender.trace.push_back(elapsed.cpu_seconds * trace_fraction * ns);
  contender.stamps.push_back(stamps(wave.stats) * stamp_cost * ns);
}

}  // namespace

std::vector<LaneCost> measure_null_hypothesis(const Scene& scene, int runs) {
  const auto tiles = choose_tiles(scene.film());
  const double stamp_cost = timestamp_cost();
  const int full = Wave::default_capacity(WaveNeeds::of(StageContext(scene)));
  Contender contenders[] = {{"scalar", run_pass<Scalar>, 1, {}, {}, {}},
                            {"wide", run_pass<Wide>, 1, {}, {}, {}},
                            {"scalar", run_pass<Scalar>, full, {}, {}, {}},
                            {"wide", run_pass<Wide>, full, {}, {}, {}}};
  for (int round = 0; round < runs; ++round)
    for (Contender& contender : contenders) run_round(scene, tiles, stamp_cost, contender);
  std::vector<LaneCost> costs;
  for (const Contender& c : contenders)
    costs.push_back({c.lane, c.wave_size, median(c.total), median(c.trace), median(c.stamps)});
  return costs;
}

}  // namespace sheaf
