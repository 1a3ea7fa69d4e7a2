// The renderer: divides camera samples into tasks, runs them on workers, and adds the samples to the film in order.
#pragma once

#include "kernels/film/aovs.h"
#include "kernels/film/sample_range.h"
#include "kernels/passes/render_report.h"
#include "kernels/render/caustic_mode.h"
#include "kernels/render/render_state.h"
#include "kernels/training/guiding_mode.h"
#include "scene/scene.h"

#include <atomic>
#include <functional>
#include <optional>

namespace sheaf {

class RayRecorder;

/// Settings of a render that do not change the scene.
struct RenderOptions {
  std::optional<std::uint32_t> samples_per_pixel;  ///< default: that of the scene
  std::optional<std::uint32_t> seed;               ///< default: that of the scene
  int threads = 0;                                 ///< 0: all processors
  int wave_size = 0;                               ///< paths in flight per worker; 0: by the L2 cache
  int spectral_bins = 0;                           ///< see Film; only in spectral mode
  /// Number of sets of samples (replicates) that are independent of each other, so that their spread gives the
  /// variance. More sets estimate it better, but each is stratified less well: the squared error grows by some 5 % with
  /// 2 sets of 16 samples, and by 10 to 20 % with 4. 1: none; the image has variances only if samples are independent
  /// anyway and contribute to one pixel. 0: 8 if samples are independent, which costs nothing; otherwise 1 below 32
  /// spp, and then one per 32 spp, at least 2 and at most 16.
  int replicates = 0;
  /// Adaptive sampling: samples every tile until its noise falls below this value (see AdaptiveGoal), or until it has
  /// samples_per_pixel. 0: all pixels get the same number of samples.
  double noise_target = 0;
  /// Seconds after which no more samples are started, once every tile has some. 0: no limit. The image then depends on
  /// the machine.
  double time_limit = 0;
  /// The samples of each pixel to be taken. They are the same as in a full render: merging the images of all parts
  /// gives the image of all samples. Default: all.
  std::optional<SampleRange> samples;
  AovSet aovs;                ///< further layers; "variance" and "half" need two replicates or more
  bool light_groups = false;  ///< layers with the contribution of each of SceneNames::lights
  /// Path guiding, with training passes before the image is rendered. They also choose the number of light candidates
  /// unless the scene sets it, see has_candidate_trial().
  GuidingMode guiding = GuidingMode::kOff;
  /// How paths find caustics. kManifold requires an integrator of paths, next-event estimation, and a scene without
  /// participating media, transparent surfaces and motion.
  CausticMode caustics = CausticMode::kSampled;
  std::optional<PixelRect> crop;  ///< default: that of the scene, otherwise the whole frame
  /// Called concurrently by workers after each task, with the number of samples done and in total.
  std::function<void(std::uint64_t done, std::uint64_t total)> on_progress;
  /// Called concurrently, once per worker, to create its Wave::recorder; for benchmarks.
  std::function<RayRecorder*()> make_recorder;
  const std::atomic<bool>* stop = nullptr;  ///< polled between tasks; true ends the render early
  /// State to resume from; it is moved from. Must be of a render of the same scene and options, except for threads and
  /// wave size. Null: a new render.
  RenderState* resume = nullptr;
  /// Polled concurrently by workers between tasks; true pauses all of them for on_pause.
  std::function<bool()> wants_pause;
  /// Called while all workers pause, and once at the end of a completed or stopped render.
  std::function<void(const RenderState&)> on_pause;
  /// Called before on_pause, with the statistics since the render was started or resumed. The report does not include
  /// the noise, which takes longer to compute.
  std::function<void(const RenderReport&)> on_report;
};

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

/// Maximum number of light groups with layers.
inline constexpr std::size_t kMaxLightGroups = 64;

/// Maximum of RenderOptions::wave_size: slots have 16 bits.
inline constexpr int kMaxWaveSize = 32768;

/// Number of replicates for that many samples per pixel if none is requested; see RenderOptions::replicates.
std::uint32_t default_replicates(SamplerKind kind, std::uint64_t samples);

/// Renders the scene. The bits of the image depend only on scene, seed and sample count, not on threads, wave size or
/// crop. Throws Error (usage) if the crop exceeds the frame or a number is out of range. Also if spectral bins are
/// requested in RGB mode, guiding or caustics that the integrator or the scene does not allow, or layers that the
/// integrator cannot render. Throws the error of check_memory() if the render does not fit into memory.
RenderResult render(const Scene& scene, const RenderOptions& options);

}  // namespace sheaf
