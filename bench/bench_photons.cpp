// The cost of photon maps: gathering at surface vertices and along rays in fog, and building. "per_item" is in seconds
// per query, or per photon for building. "per_photon" is per photon found, "photons" their number.
#include "core/io/error.h"
#include "core/sampling/octahedral.h"
#include "core/simd/flush_denormals.h"
#include "kernels/film/camera_task.h"
#include "kernels/film/film_layout.h"
#include "kernels/passes/trace_photons.h"
#include "kernels/photons/photon_maps.h"
#include "kernels/stages/stage_list.h"
#include "kernels/wave/wave_snapshot.h"
#include "scene/compile/compile.h"
#include "scene/dialects/read_scene.h"

#include <benchmark/benchmark.h>

#include <ctime>
#include <filesystem>
#include <memory>
#include <string>

namespace sheaf {

namespace {

constexpr std::uint64_t kPhotons = 1'000'000;

std::unique_ptr<Scene> load_scene(const char* file) {
  return compile_scene(read_scene(std::filesystem::path(SHEAF_SOURCE_DIR) / file));
}

/// Traces and stores photons as a render does.
template <class Trace>
auto traced(const Scene& scene, PhotonKind kind, std::uint64_t count, float radius, int lookup_size, Trace&& trace) {
  IntegratorSettings integrator = scene.integrator();
  integrator.photons.lookup_size = lookup_size;
  const StageContext context(scene, integrator);
  Workers workers([&] { return Worker(Wave::default_capacity(WaveNeeds::of(context)), WaveNeeds::of(context)); });
  PhotonTracing tracing{[] { return false; }, [](std::uint64_t) {}};
  const std::uint64_t emitted = photons_to_emit(context, workers, kind, count, 64 * count, tracing);
  return trace(context, workers, PhotonRequest{emitted, radius, kind, 0}, tracing);
}

/// A wave of camera rays, spread over the image, that has reached a stage that gathers.
class GatheringWave {
 public:
  GatheringWave(const Scene& scene, const PhotonMaps& maps, Stage end)
      : context_(scene, task_), wave_(Wave::default_capacity(WaveNeeds::of(context_)), WaveNeeds::of(context_)) {
    context_.gather_from(maps);
    const FilmSettings& film = scene.film();
    const int side = 16;
    pixels_ = samples_of({film.width / 2 - side, film.height / 4, film.width / 2 + side, film.height / 4 * 3},
                         {film.width}, 0, 4);
    task_.begin(pixels_, {film.width}, kBeautyChannels);
    for (std::size_t i = 0; i < static_cast<std::size_t>(end); ++i)
      if (kStages<Wide>[i].takes_part(context_)) kStages<Wide>[i].run(context_, wave_);
  }

  /// Times the stage by its own counter. `found`: number of photons that all queries find.
  void run(benchmark::State& state, Stage stage, double found) {
    const WaveSnapshot snapshot(wave_);
    StageStats& stats = wave_.stats[stage];
    stats = {};
    for (auto _ : state) {
      snapshot.restore(wave_);
      const std::uint64_t before = stats.ticks;
      run_once(stage);
      state.SetIterationTime(static_cast<double>(stats.ticks - before) * seconds_per_tick());
    }
    const double items = static_cast<double>(stats.items) / static_cast<double>(stats.calls);
    const auto rate = [](double of) {
      return benchmark::Counter(of, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
    };
    state.counters["per_item"] = rate(items);
    state.counters["per_photon"] = rate(found);
    state.counters["photons"] = found / items;
  }

  /// Moves the diffuse vertices to random photons, or all to one.
  void move_to_photons(const PhotonMapView& map, std::uint32_t seed, bool same) {
    const VertexRun& run = wave_.runs[static_cast<int>(kClosureKind<DiffuseClosure>)];
    for (int i = 0; i < run.count; ++i) {
      const Random4<Scalar> u = random4<Scalar>(seed, same ? 0u : static_cast<std::uint32_t>(i), 0, 0);
      const Photon photon = map.photon(static_cast<std::uint32_t>(u.x * static_cast<float>(map.size - 1)));
      auto item = wave_.vertices.load<Scalar>(run.column_begin + i);
      item.p = photon.p;
      item.ng = item.ns = decode_octahedral<Scalar>(photon_normal(photon.surface));
      wave_.vertices.store<Scalar>(run.column_begin + i, item);
    }
  }

  void run_once(Stage stage) { kStages<Wide>[static_cast<std::size_t>(stage)].run(context_, wave_); }

  Wave& wave() { return wave_; }

 private:
  CameraTask task_;
  std::vector<PixelSamples> pixels_;
  StageContext context_;
  Wave wave_;
};

void gather_around(benchmark::State& state, float radius, int lookup_size) {
  const FlushDenormals flush;
  const auto scene = load_scene("scenes/cornell/cornell.xml");
  const PhotonMap map = traced(*scene, PhotonKind::kAll, kPhotons, radius, lookup_size, trace_photons);
  const PhotonMaps maps{map.view(), {}, PhotonGathering::kAll};
  GatheringWave gathering(*scene, maps, stage_named("gather"));
  Wave& wave = gathering.wave();
  const WaveSnapshot snapshot(wave);
  gathering.run_once(stage_named("gather"));
  snapshot.restore(wave);
  gathering.run(state, stage_named("gather"), static_cast<double>(wave.stats.gathering.photons));
}

/// CPU time of this thread, s.
double thread_seconds() {
  timespec time;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// Queries all over a map of 2 million photons, as by final gathering, or at one photon. Other programs do not count:
/// times are CPU times.
void gather_at_random(benchmark::State& state, float radius, bool same) {
  const FlushDenormals flush;
  const auto scene = load_scene("scenes/cornell/cornell.xml");
  const PhotonMap map = traced(*scene, PhotonKind::kAll, 2 * kPhotons, radius, 0, trace_photons);
  const PhotonMaps maps{map.view(), {}, PhotonGathering::kAll};
  GatheringWave gathering(*scene, maps, stage_named("gather"));
  Wave& wave = gathering.wave();
  const WaveSnapshot snapshot(wave);
  std::uint32_t seed = 0;
  double queries = 0, photons = 0, seconds = 0;
  for (auto _ : state) {
    snapshot.restore(wave);
    gathering.move_to_photons(map.view(), seed++, same);
    const auto before = wave.stats.gathering;
    const double start = thread_seconds();
    gathering.run_once(stage_named("gather"));
    const double elapsed = thread_seconds() - start;
    state.SetIterationTime(elapsed);
    seconds += elapsed;
    queries += static_cast<double>(wave.stats.gathering.queries - before.queries);
    photons += static_cast<double>(wave.stats.gathering.photons - before.photons);
  }
  state.counters["per_item"] = seconds / queries;
  state.counters["per_photon"] = seconds / photons;
  state.counters["photons"] = photons / queries;
}

void gather_along(benchmark::State& state, float radius) {
  const FlushDenormals flush;
  const auto scene = load_scene("scenes/media/fog.xml");
  const VolumePhotonMaps volume = traced(*scene, PhotonKind::kVolume, kPhotons, radius, 0, trace_volume_photons);
  const VolumePhotonMap& map = volume.points;
  const PhotonMaps maps{{}, {}, PhotonGathering::kAll, &volume};
  GatheringWave gathering(*scene, maps, stage_named("gather_volume"));
  Wave& wave = gathering.wave();
  std::vector<NearPoint> found;
  for (const Slot slot : wave.medium.span()) {
    const RayState<Scalar> ray = wave.rays.get(slot);
    map.points().near_ray(ray.origin, ray.direction, wave.hits.get(slot).t, found);
  }
  gathering.run(state, stage_named("gather_volume"), static_cast<double>(found.size()));
}

/// Photons all over a square, as on a floor.
std::vector<Photon> photons_on_floor() {
  std::vector<Photon> photons(kPhotons);
  for (std::uint32_t i = 0; i < kPhotons; ++i) {
    const Random4<Scalar> u = random4<Scalar>(1, i, 0, 0);
    photons[i].p = {u.x, 0, u.y};
  }
  return photons;
}

template <class Map> void build(benchmark::State& state) {
  const std::vector<Photon> photons = photons_on_floor();
  for (auto _ : state) {
    const Map map({photons}, kPhotons, 0.01f, PhotonKernel::kDisc);
    benchmark::DoNotOptimize(map.bytes());
  }
  state.counters["per_item"] =
      benchmark::Counter(kPhotons, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

[[maybe_unused]] const bool registered = [] {
  for (const float radius : {0.005f, 0.02f, 0.08f}) {
    const std::string r = std::to_string(radius).substr(0, 5);
    benchmark::RegisterBenchmark(("photons/around/radius_" + r).c_str(), gather_around, radius, 0)->UseManualTime();
    benchmark::RegisterBenchmark(("photons/along/radius_" + r).c_str(), gather_along, radius)->UseManualTime();
  }
  benchmark::RegisterBenchmark("photons/at_random", gather_at_random, 0.037f, false)->UseManualTime();
  benchmark::RegisterBenchmark("photons/at_one", gather_at_random, 0.037f, true)->UseManualTime();
  benchmark::RegisterBenchmark("photons/around/nearest_50", gather_around, 0.08f, 50)->UseManualTime();
  benchmark::RegisterBenchmark("photons/build/surfaces", build<PhotonMap>)
      ->UseRealTime()
      ->Unit(benchmark::kMillisecond);
  benchmark::RegisterBenchmark("photons/build/media", build<VolumePhotonMap>)
      ->UseRealTime()
      ->Unit(benchmark::kMillisecond);
  return true;
}();

}  // namespace

}  // namespace sheaf
