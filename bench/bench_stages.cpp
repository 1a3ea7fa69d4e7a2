// The cost per item of each stage of the path and light passes, on waves in the middle of a render. Every benchmark
// reports "per_item" in seconds, "best_per_item" for the shortest call, and the number of items per call.
#include "core/io/error.h"
#include "core/simd/flush_denormals.h"
#include "kernels/film/camera_task.h"
#include "kernels/film/film_layout.h"
#include "kernels/photons/light_task.h"
#include "kernels/stages/stage_list.h"
#include "kernels/wave/wave_snapshot.h"
#include "scene/compile/compile.h"
#include "scene/dialects/read_scene.h"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace sheaf {

namespace {

/// The settings of the scene, with the light tracer for the light pass.
IntegratorSettings settings_of(const Scene& scene, PassKind pass) {
  IntegratorSettings settings = scene.integrator();
  if (pass == PassKind::kLight) settings.kind = IntegratorKind::kLightTracer;
  return settings;
}

/// A wave that has rendered the middle of the image for a while, so that it holds paths of all lengths; or a wave of
/// the light pass.
class WarmWave {
 public:
  WarmWave(const Scene& scene, PassKind pass)
      : settings_(settings_of(scene, pass)),
        context_(scene, settings_),
        wave_(Wave::default_capacity(WaveNeeds::of(context_)), WaveNeeds::of(context_)) {
    context_.set_camera_task(task_);
    if (pass == PassKind::kLight) context_.start_at_lights(pass, photons_);
    const FilmSettings& film = scene.film();
    bounds_ = {-0.5f, -0.5f, static_cast<float>(film.width) + 0.5f, static_cast<float>(film.height) + 0.5f};
    const int x = std::max(0, (film.width - kSide) / 2), y = std::max(0, (film.height - kSide) / 2);
    pixels_ =
        samples_of({x, y, std::min(film.width, x + kSide), std::min(film.height, y + kSide)}, {film.width}, 0, kSpp);
    task_.begin(pixels_, {film.width}, kBeautyChannels);
    rewind_photons();
    for (int step = 0; step < kSteps; ++step) advance(static_cast<Stage>(kStages<Wide>.size()));
    while (!refilling()) advance(static_cast<Stage>(kStages<Wide>.size()));
  }

  /// Runs a step of the pass up to, but not including, a stage.
  void advance(Stage end) {
    for (std::size_t i = 0; i < static_cast<std::size_t>(end); ++i) {
      const StageEntry& stage = kStages<Wide>[i];
      const bool waits = stage.is_source() && !refilling();
      if (!waits && stage.takes_part(context_)) stage.run(context_, wave_);
    }
  }

  /// Restarts all photons, and discards what they have splatted.
  void rewind_photons() { photons_.begin(0, kPhotons, bounds_); }

  const StageContext& context() const { return context_; }
  Wave& wave() { return wave_; }
  CameraTask& task() { return task_; }

 private:
  static constexpr int kSide = 64, kSpp = 64, kSteps = 32, kPhotons = 1 << 20;
  bool refilling() const { return 2 * wave_.free.size() >= wave_.capacity; }

  CameraTask task_;
  LightTask photons_;
  SplatFilter::Bounds bounds_{};
  std::vector<PixelSamples> pixels_;
  IntegratorSettings settings_;
  StageContext context_;
  Wave wave_;
};

const Scene& load_scene(const char* file) {
  static std::map<std::string, std::unique_ptr<Scene>> scenes;
  std::unique_ptr<Scene>& scene = scenes[file];
  if (!scene) scene = compile_scene(read_scene(std::filesystem::path(SHEAF_SOURCE_DIR) / file));
  return *scene;
}

/// Times one stage by its own counter, which excludes restoring the wave.
void run_stage(benchmark::State& state, const char* file, const StageEntry& stage) try {
  const FlushDenormals flush;
  // Advance the wave to the stage
  WarmWave warm(load_scene(file), stage.takes_part == condition::starts_at_lights ? PassKind::kLight : PassKind::kPath);
  if (!stage.takes_part(warm.context())) return state.SkipWithError("the scene does not use this stage");
  warm.advance(stage.stage);
  Wave& wave = warm.wave();
  const WaveSnapshot snapshot(wave);
  const CameraTask::Cursor cursor = warm.task().cursor;
  StageStats& stats = wave.stats[stage.stage];
  stats = {};
  std::uint64_t shortest = std::numeric_limits<std::uint64_t>::max();
  // Run the stage repeatedly from the same state
  for (auto _ : state) {
    snapshot.restore(wave);
    warm.task().cursor = cursor;
    warm.rewind_photons();
    const std::uint64_t before = stats.ticks;
    stage.run(warm.context(), wave);
    const std::uint64_t ticks = stats.ticks - before;
    state.SetIterationTime(static_cast<double>(ticks) * seconds_per_tick());
    shortest = std::min(shortest, ticks);
  }
  // Report the counters
  if (stats.items == 0) return state.SkipWithError("no items reach this stage");
  const double items = static_cast<double>(stats.items) / static_cast<double>(stats.calls);
  state.SetItemsProcessed(static_cast<std::int64_t>(stats.items));
  state.counters["items"] = items;
  state.counters["best_per_item"] = static_cast<double>(shortest) * seconds_per_tick() / items;
  state.counters["per_item"] =
      benchmark::Counter(items, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
} catch (const Error& error) { state.SkipWithError(error.what()); }

template <class L> void add_stages(const std::string& scene, const char* file, const char* lane) {
  for (const StageEntry& stage : kStages<L>) {
    if (stage.takes_part == condition::in_debug_pass) continue;
    const std::string name = fmt::format("{}/{}/{}", scene, stage.name, lane);
    benchmark::RegisterBenchmark(name.c_str(), run_stage, file, stage)->UseManualTime();
  }
}

bool add_scene(const std::string& name, const char* file) {
  add_stages<Scalar>(name, file, "scalar");
  add_stages<Wide>(name, file, "wide");
  return true;
}

[[maybe_unused]] const bool registered =
    add_scene("cornell", "scenes/cornell/cornell.xml") && add_scene("mesh_box", "scenes/mesh_box/mesh_box.xml");

}  // namespace

}  // namespace sheaf
