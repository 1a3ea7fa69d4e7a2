// The renderer: divides camera samples into tasks, runs them on workers, and adds the samples to the film in order.
#pragma once

#include "kernels/passes/render_report.h"
#include "kernels/render/light_group_layers.h"
#include "kernels/render/render_progress.h"
#include "kernels/render/render_settings.h"
#include "kernels/render/render_state.h"
#include "scene/scene.h"

#include <atomic>
#include <functional>
#include <optional>

namespace sheaf {

class RayRecorder;

/// How a render runs, and its callbacks. The bits of the image do not depend on it unless it is stopped.
struct RenderControl {
  int threads = 0;    ///< 0: all processors
  int wave_size = 0;  ///< paths in flight per worker; 0: by the L2 cache
  /// Called concurrently by workers after each task.
  std::function<void(const RenderProgress&)> on_progress = {};
  /// Called concurrently, once per worker, to create its Wave::recorder; for benchmarks.
  std::function<RayRecorder*()> make_recorder = {};
  const std::atomic<bool>* stop = nullptr;  ///< polled between tasks; true ends the render early
  /// State to resume from; it is moved from. Must be of a render of the same scene and settings. Null: a new render.
  RenderState* resume = nullptr;
  /// Called after a render was stopped; true: its result is not used, so it has no noise and lacks the last samples.
  std::function<bool()> discards_result = {};
  /// Polled concurrently by workers between tasks; true pauses all of them for on_pause.
  std::function<bool()> wants_pause = {};
  /// Called while all workers pause, and once at the end of a completed or stopped render.
  std::function<void(const RenderState&)> on_pause = {};
  /// Called before on_pause, with the statistics since the render was started or resumed. The report does not include
  /// the noise, which takes longer to compute.
  std::function<void(const RenderReport&)> on_report = {};
};

/// A request for a render of a compiled scene, and how it runs.
struct RenderOptions : RenderRequest, RenderControl {};

/// Noise of the image: Film::noise(), or image_noise() of the image with splats. Empty if there are splats but no
/// photon has been emitted yet.
std::optional<double> noise_of(const Film& film, const std::optional<SplatFilm>& splats, std::uint64_t photons);

struct RenderResult {
  Film film;
  std::optional<SplatFilm> splats;     ///< light tracing: contributions of photons
  std::uint64_t photons = 0;           ///< number of photons emitted
  AovSet aovs;                         ///< layers that were requested
  SceneNames names;                    ///< names of surfaces, if the film has surface ids
  std::optional<SampleRange> samples;  ///< if only some samples were requested: those, of RenderReport::spp
  RenderReport report;                 ///< without scene file and load times, which the caller adds
  bool interrupted = false;
  std::vector<std::string> warnings;

  /// The image: Film::to_image(), the splats, and the layers of surface ids. If only some samples were requested, it
  /// includes the layers that merging needs (kernels/film/merge.h).
  Image to_image() const;
};

/// Maximum of RenderControl::wave_size: slots have 16 bits.
inline constexpr int kMaxWaveSize = 32768;

/// Renders the scene, which was compiled with the settings. The bits of the image depend only on scene, seed and sample
/// count, not on threads, wave size or crop. Throws Error (usage) for a wave size above kMaxWaveSize, and if the scene
/// cannot be rendered with the settings. Throws the error of check_memory() if the render does not fit into memory.
RenderResult render(const Scene& scene, const RenderSettings& settings, const RenderControl& control);

/// The same with the settings of the scene. Also throws the errors of resolve_settings().
RenderResult render(const Scene& scene, const RenderOptions& options);

}  // namespace sheaf
