// Sets up a render, runs it, and collects its result.
#include "kernels/render/render.h"

#include "core/io/error.h"
#include "kernels/film/cryptomatte.h"
#include "kernels/film/noise.h"
#include "kernels/render/render_memory.h"
#include "kernels/render/task_runner.h"

#include <new>

namespace sheaf {

namespace {

/// The result of a render that has ended.
RenderResult result_of(const Scene& scene, const RenderOptions& options, SamplePlan& plan,
                       const ProgressReporter& reporter, const TaskRunner& runner) {
  plan.complete_film();
  RenderResult result;
  result.interrupted = plan.is_incomplete();
  result.warnings = runner.warnings();
  result.report = reporter.report(plan, runner.statistics(), result.warnings);
  RenderState state = plan.take_state();
  result.report.interrupted = result.interrupted;
  result.report.noise = noise_of(state.film, state.splats, state.photons);
  result.film = std::move(state.film);
  result.aovs = options.aovs;
  if (result.film.has_surface_ids()) result.names = scene.names();
  result.splats = std::move(state.splats);
  result.photons = state.photons;
  if (options.samples) result.samples = plan.layout().range;
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

RenderResult render(const Scene& scene, const RenderOptions& options) {
  const SampleLayout layout = make_sample_layout(scene, options);
  const std::vector<MemoryUse> memory = render_memory(scene, options, layout);
  const std::string task =
      "an image of " + std::to_string(layout.crop.width()) + " x " + std::to_string(layout.crop.height()) + " pixels";
  check_memory(task, memory);
  try {
    SamplePlan plan(scene, options, layout);
    ProgressReporter reporter(scene, options, plan.samples_before());
    TaskRunner runner(scene, options, plan, reporter);
    runner.run();
    RenderResult result = result_of(scene, options, plan, reporter, runner);
    result.report.memory = memory;
    return result;
  } catch (const std::bad_alloc&) { throw not_enough_memory(task, memory); }
}

}  // namespace sheaf
