// What each stage of the path pass costs per item, on waves as they are in the middle of a render. Every benchmark
// reports "per_item" in seconds, "best_per_item" for the shortest call, and how many items the stage consumes in one.
#include "core/error.h"
#include "kernels/stages.h"
#include "scene/compile.h"
#include "scene/read_scene.h"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace sheaf {

namespace {

using StageFunction = void (*)(const SceneView&, Wave&) noexcept;

template <class L>
constexpr StageFunction kStageFunctions[kStageCount] = {
    camera_rays<L>, intersect<L>,        emission<L>, select_materials<L>, sort_surfaces<L>, surface_inputs<L>,
    textures<L>,    light_candidates<L>, resample<L>, shadow<L>,           scatter<L>,       accumulate<L>};

/// What stages consume: lists, slots' records and counts. Columns need no copy, since no stage overwrites its input.
class WaveSnapshot {
 public:
  explicit WaveSnapshot(Wave& wave) : shadow_count_(wave.shadow_count), next_sample_(wave.next_sample) {
    for (const SlotList* list : lists(wave)) lists_.emplace_back(list->span().begin(), list->span().end());
    for (const Rows& rows : groups(wave)) groups_.emplace_back(rows.begin, rows.begin + rows.size);
    std::copy(std::begin(wave.runs), std::end(wave.runs), runs_.begin());
  }

  void restore(Wave& wave) const {
    for (std::size_t i = 0; i < lists_.size(); ++i) {
      lists(wave)[i]->resize(static_cast<int>(lists_[i].size()));
      std::copy(lists_[i].begin(), lists_[i].end(), lists(wave)[i]->data());
    }
    for (std::size_t i = 0; i < groups_.size(); ++i)
      std::copy(groups_[i].begin(), groups_[i].end(), groups(wave)[i].begin);
    std::copy(runs_.begin(), runs_.end(), std::begin(wave.runs));
    wave.sorted.pad();
    wave.shadow_count = shadow_count_;
    wave.next_sample = next_sample_;
  }

 private:
  struct Rows {
    float* begin;
    std::ptrdiff_t size;
  };
  static std::array<SlotList*, 7> lists(Wave& w) {
    return {&w.free, &w.active, &w.miss, &w.emitter, &w.surface, &w.finished, &w.sorted};
  }
  static std::array<Rows, 4> groups(Wave& w) {
    const std::ptrdiff_t words = static_cast<std::ptrdiff_t>(w.capacity) * Groups<RayState>::kWords;
    return {{{w.rays.row(0), words}, {w.hits.row(0), words}, {w.throughput.row(0), words}, {w.radiance.row(0), words}}};
  }

  std::vector<std::vector<Slot>> lists_;
  std::vector<std::vector<float>> groups_;
  std::array<SurfaceRun, kClosureKinds> runs_;
  int shadow_count_, next_sample_;
};

/// A wave that has rendered the middle of the picture for a while, so that it holds paths of all lengths.
class WarmWave {
 public:
  explicit WarmWave(const Scene& scene)
      : view_(scene.view()), wave_(Wave::default_capacity()), samples_(kSide * kSide * kSpp) {
    const FilmDescription& film = scene.film();
    const int x = std::max(0, (film.width - kSide) / 2), y = std::max(0, (film.height - kSide) / 2);
    wave_.begin({{x, y, std::min(film.width, x + kSide), std::min(film.height, y + kSide)}, 0, kSpp, film.width},
                samples_.data());
    for (int step = 0; step < kSteps; ++step) advance(Stage::kCount);
    while (!refilling()) advance(Stage::kCount);
  }

  /// Runs a step of the pass up to, but not including, a stage.
  void advance(Stage end) {
    for (std::size_t i = 0; i < static_cast<std::size_t>(end); ++i)
      if (i > 0 || refilling()) kStageFunctions<Wide>[i](view_, wave_);
  }

  const SceneView& view() const { return view_; }
  Wave& wave() { return wave_; }

 private:
  static constexpr int kSide = 64, kSpp = 64, kSteps = 32;
  bool refilling() const { return 2 * wave_.free.size() >= wave_.capacity; }

  SceneView view_;
  Wave wave_;
  std::vector<FilmSample> samples_;
};

const Scene& load_scene(const char* file) {
  static std::map<std::string, std::unique_ptr<Scene>> scenes;
  std::unique_ptr<Scene>& scene = scenes[file];
  if (!scene) scene = compile_scene(read_scene(std::filesystem::path(SHEAF_SOURCE_DIR) / file));
  return *scene;
}

/// Times one stage by its own counter, so that putting the wave back is not counted.
void run_stage(benchmark::State& state, const char* file, Stage stage, StageFunction function) try {
  const FlushDenormals flush;
  WarmWave warm(load_scene(file));
  warm.advance(stage);
  Wave& wave = warm.wave();
  const WaveSnapshot snapshot(wave);
  StageStats& stats = wave.stats[stage];
  stats = {};
  std::uint64_t shortest = std::numeric_limits<std::uint64_t>::max();
  for (auto _ : state) {
    snapshot.restore(wave);
    const std::uint64_t before = stats.ticks;
    function(warm.view(), wave);
    const std::uint64_t ticks = stats.ticks - before;
    state.SetIterationTime(static_cast<double>(ticks) * seconds_per_tick());
    shortest = std::min(shortest, ticks);
  }
  if (stats.items == 0) return state.SkipWithError("no items reach this stage");
  const double items = static_cast<double>(stats.items) / static_cast<double>(stats.calls);
  state.SetItemsProcessed(static_cast<std::int64_t>(stats.items));
  state.counters["items"] = items;
  state.counters["best_per_item"] = static_cast<double>(shortest) * seconds_per_tick() / items;
  state.counters["per_item"] =
      benchmark::Counter(items, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
} catch (const Error& error) {
  state.SkipWithError(error.what());
}

template <class L> void add_stages(const std::string& scene, const char* file, const char* lane) {
  for (std::size_t i = 0; i < kStageCount; ++i) {
    const auto stage = static_cast<Stage>(i);
    const std::string name = scene + "/" + std::string(stage_name(stage)) + "/" + lane;
    benchmark::RegisterBenchmark(name.c_str(), run_stage, file, stage, kStageFunctions<L>[i])->UseManualTime();
  }
}

bool add_scene(const std::string& name, const char* file) {
  add_stages<Scalar>(name, file, "scalar");
  add_stages<Wide>(name, file, "wide");
  return true;
}

[[maybe_unused]] const bool registered = add_scene("cornell", "scenes/cornell/cornell.xml") &&
                                         add_scene("mesh_box", "scenes/mesh_box/mesh_box.xml");

}  // namespace

}  // namespace sheaf
