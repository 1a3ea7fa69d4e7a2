// Runs rounds of tasks in parallel, with pauses between tasks.
#include "kernels/render/task_runner.h"

#include "core/simd/flush_denormals.h"
#include "kernels/passes/passes.h"

#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>

namespace sheaf {

namespace {

/// The surfaces that cast caustics, if paths are connected to lights by them.
std::optional<CausticCasters> casters_of(const Scene& scene, const RenderSettings& settings) {
  if (settings.caustics != CausticMode::kManifold) return std::nullopt;
  CausticCasters casters(scene.view());
  if (casters.empty()) return std::nullopt;
  return casters;
}

/// The context of camera rounds.
StageContext camera_context(const Scene& scene, const RenderSettings& settings,
                            const std::optional<CausticCasters>& casters) {
  StageContext context(scene, settings.integrator);
  context.sampler = make_sampler(settings.sampler.kind, settings.sampler.seed, settings.replicate_samples,
                                 static_cast<std::uint32_t>(settings.frame.row_length()));
  // Photons do not find light that reaches the camera unscattered, so the camera takes only that.
  if (context.integrator.traits().connects_photons()) context.max_depth = 1;
  if (casters) context.connect_caustics(*casters);
  return context;
}

/// Adds the samples of a finished task to its tile, in the order of each pixel's samples.
void reduce(const CameraTask& task, FilmTile& tile) {
  std::size_t sample = 0;
  for (const PixelSamples& p : task.pixels()) {
    const int x = task.frame().x(p.pixel), y = task.frame().y(p.pixel);
    tile.add(x, y, task.samples, sample, p.sample_count);
    sample += p.sample_count;
  }
}

}  // namespace

TaskRunner::TaskRunner(const Scene& scene, const RenderControl& control, SamplePlan& plan, ProgressReporter& reporter)
    : control_(control),
      plan_(plan),
      reporter_(reporter),
      casters_(casters_of(scene, plan.settings())),
      context_(camera_context(scene, plan.settings(), casters_)),
      light_(context_, plan.settings(), reporter),
      threads_(threads_of(control)),
      wave_(wave_setup(scene, plan.settings(), control)),
      workers_([this] {
        return Worker(wave_.size, wave_.needs, control_.make_recorder ? control_.make_recorder() : nullptr);
      }) {}

void TaskRunner::run() {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads_));
  tbb::task_arena arena(threads_);
  arena.execute([this] {
    while (!ends() && plan_.begin_round()) run_round();
    plan_.end(reporter_.is_stopped());
    reporter_.pause(plan_, statistics());
  });
}

/// Runs a round to its end, unless the render is stopped.
void TaskRunner::run_round() {
  reporter_.set_total(plan_.sample_total() + light_.photon_total(), plan_.min_sample_total(),
                      !plan_.knows_sample_total());
  if (plan_.round() == RoundKind::kTraining) light_.train(plan_.settings(), workers_, context_);
  if (plan_.round() == RoundKind::kCamera) light_.prepare(plan_.state().first_sample, workers_, context_);
  for (bool is_done = false; !is_done && !ends();) {
    run_tasks();
    is_done = plan_.end_round();
    // The splats of a photon round are in no checkpoint, so it is not interrupted.
    if (plan_.round() == RoundKind::kPhotons) reporter_.wants_pause();
    if (reporter_.is_pausing()) reporter_.pause(plan_, statistics());
  }
}

/// Runs the remaining tasks of the round until a pause is requested.
void TaskRunner::run_tasks() {
  const bool pauses = plan_.round() == RoundKind::kCamera;
  tbb::parallel_for(
      tbb::blocked_range<std::size_t>(0, plan_.task_count(), 1),
      [&](const tbb::blocked_range<std::size_t>& range) {
        for (std::size_t i = range.begin(); i < range.end(); ++i)
          if (!plan_.is_done(i) && !ends() && !(pauses && reporter_.wants_pause())) run_task(i);
      },
      tbb::simple_partitioner());
}

void TaskRunner::run_task(std::size_t index) {
  Worker& worker = workers_.local();
  if (plan_.round() == RoundKind::kPhotons) {
    trace_photons(plan_.photon_task(index), worker);
    plan_.finish_photons(index, worker.photons.splats);
  } else {
    take_samples(plan_.tile_task(index), worker);
    plan_.finish_tile(index, worker.tile);
  }
}

/// Takes the samples of a task, and adds them to the worker's tile.
void TaskRunner::take_samples(const TileTask& task, Worker& worker) const {
  plan_.begin_tile(task, worker.tile);
  for (std::uint32_t taken = 0; taken < task.sample_count; taken += task.samples_at_once)
    take_samples(task, task.first_sample + taken, std::min(task.samples_at_once, task.sample_count - taken), worker);
}

void TaskRunner::take_samples(const TileTask& task, std::uint32_t first_sample, std::uint32_t sample_count,
                              Worker& worker) const {
  const FlushDenormals flush;
  const RenderSettings& settings = plan_.settings();
  const Film& film = plan_.state().film;
  const std::vector<PixelSamples> pixels = samples_of(task.tile.sampled, settings.frame, first_sample, sample_count);
  worker.camera.begin(pixels, settings.frame, film.layout().size(), film.spectral_bins(),
                      AovChannels(film.layout(), settings.aovs));
  worker.wave.light_groups = group_sink(worker.camera);
  worker.wave.max_indirect = settings.clamp_indirect * (settings.color == ColorMode::kSpectral ? 4.0f : 3.0f);
  StageContext context = context_;
  context.set_camera_task(worker.camera);
  context.sampler = sampler_of_replicate(context_.sampler, task.replicate, task.replicate_samples);
  run_pass<Wide>(context, worker.wave);
  worker.wave.light_groups.reset();
  worker.wave.max_indirect = kInfinity;
  reduce(worker.camera, worker.tile);
  reporter_.add_done(static_cast<std::uint64_t>(worker.camera.total()));
}

/// Traces the photons of a task, and stores their splats in the worker's light task.
void TaskRunner::trace_photons(const PhotonTask& task, Worker& worker) const {
  const FlushDenormals flush;
  worker.photons.begin(task.first, task.count, plan_.splat_bounds());
  StageContext context = context_;
  context.start_at_lights(PassKind::kLight, worker.photons);
  context.max_depth = context.integrator.max_depth;
  context.sampler = without_frame(context.sampler);
  run_pass<Wide>(context, worker.wave);
  worker.photons.sort_splats();
  reporter_.add_done(static_cast<std::uint64_t>(task.count));
}

/// Channels of the light groups in the samples of the worker's task.
std::optional<LightGroupSink> TaskRunner::group_sink(CameraTask& task) const {
  const LightGroupLayers& groups = plan_.light_groups();
  if (groups.names.empty()) return std::nullopt;
  const auto channels = static_cast<std::size_t>(plan_.state().film.layout().size());
  return LightGroupSink{task.samples[0] + channels - 3 * groups.names.size(),
                        channels,
                        groups.group_of_light.data(),
                        static_cast<std::uint16_t>(groups.names.size() - 1),
                        context_.scene.color,
                        context_.scene.spectral.sensor};
}

}  // namespace sheaf
