// Sets up a render, runs it, and collects its result.
#include "kernels/render/render.h"

#include "core/io/error.h"
#include "kernels/film/cryptomatte.h"
#include "kernels/film/noise.h"
#include "kernels/render/render_memory.h"
#include "kernels/render/task_runner.h"

#include <fmt/format.h>

#include <new>

namespace sheaf {

namespace {

/// The result of a render that has ended.
RenderResult result_of(const Scene& scene, const RenderControl& control, SamplePlan& plan,
                       const ProgressReporter& reporter, const TaskRunner& runner) {
  RenderResult result;
  result.interrupted = plan.is_incomplete();
  const bool is_used = !result.interrupted || !control.discards_result || !control.discards_result();
  if (is_used) plan.complete_film();
  result.warnings = runner.warnings();
  result.report = reporter.report(plan, runner.statistics(), result.warnings);
  RenderState state = plan.take_state();
  result.report.interrupted = result.interrupted;
  if (is_used) result.report.noise = noise_of(state.film, state.splats, state.photons);
  result.film = std::move(state.film);
  result.aovs = plan.settings().aovs;
  if (result.film.has_surface_ids()) result.names = scene.names();
  result.splats = std::move(state.splats);
  result.photons = state.photons;
  if (plan.settings().is_part) result.samples = plan.settings().range;
  return result;
}

}  // namespace

std::optional<double> noise_of(const Film& film, const std::optional<SplatFilm>& splats, std::uint64_t photons) {
  if (!splats) return film.noise();
  if (photons == 0) return std::nullopt;
  Image image = film.to_image();
  splats->add_to(image, photons);
  return image_noise(image);
}

Image RenderResult::to_image() const {
  Image image = film.to_image();
  if (samples) film.add_part_layers(image);
  if (splats) splats->add_to(image, photons);
  add_id_layers(aovs, names, film, image);
  if (samples) add_part_ids(aovs, names, film, image);
  return image;
}

RenderResult render(const Scene& scene, const RenderSettings& settings, const RenderControl& control) {
  check_scene(scene, settings);
  if (control.wave_size > kMaxWaveSize)
    throw Error(ExitCode::kUsage, fmt::format("the wave size must not exceed {}", kMaxWaveSize));
  const std::vector<MemoryUse> memory = render_memory(scene, settings, control);
  const std::string task = fmt::format("an image of {} x {} pixels", settings.crop.width(), settings.crop.height());
  check_memory(task, memory);
  try {
    SamplePlan plan(scene, settings, control.resume);
    ProgressReporter reporter(scene, control, plan);
    TaskRunner runner(scene, control, plan, reporter);
    runner.run();
    RenderResult result = result_of(scene, control, plan, reporter, runner);
    result.report.memory = memory;
    return result;
  } catch (const std::bad_alloc&) { throw not_enough_memory(task, memory); }
}

RenderResult render(const Scene& scene, const RenderOptions& options) {
  return render(scene, resolve_settings(scene, options), options);
}

}  // namespace sheaf
