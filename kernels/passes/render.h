// Rendering: camera samples cut into tasks, tasks given to workers, samples reduced into the film in order.
#pragma once

#include "core/stats.h"
#include "kernels/film/aovs.h"
#include "kernels/film/sample_range.h"
#include "kernels/passes/render_state.h"
#include "scene/tables/scene.h"

#include <atomic>
#include <functional>
#include <optional>

namespace sheaf {

class RayRecorder;

/// What the caller may change without touching the scene.
struct RenderOptions {
  std::optional<std::uint32_t> samples_per_pixel;  ///< default: the scene's
  std::optional<std::uint32_t> seed;               ///< default: the scene's
  int threads = 0;                                 ///< 0: all processors
  int wave_size = 0;                               ///< paths in flight per worker; 0: by the L2 cache
  int spectral_bins = 0;                           ///< see Film; only in spectral mode
  /// Into how many sets the samples are cut that are independent of each other, so that the spread of these sets tells
  /// the variance. More tell it better, and each set is spread less evenly: the squared error grows by some 5 % with 2,
  /// by 10 to 20 % with 4 sets of 16 samples. 1: none; the picture has variances only where samples are independent
  /// anyway and count in one pixel. 0: 8 where samples are independent, which costs nothing; else 1 below 32 samples
  /// per pixel, 2 below 128, 4 below 512, 8 from there on.
  int replicates = 0;
  /// Adaptive sampling: samples are taken until the noise of every tile is this, as AdaptiveGoal has it, or there are
  /// samples_per_pixel of them. 0: all pixels get as many.
  double noise_target = 0;
  /// Seconds after which no more samples are begun, once every tile has some. 0: no limit. The picture then depends on
  /// the machine.
  double time_limit = 0;
  /// Of the samples those that are taken; all others are as if they were, too: joining the parts' pictures gives that
  /// of all samples. Default: all.
  std::optional<SampleRange> samples;
  AovSet aovs;                    ///< further layers; Aov::kVariance and kHalf make at least two replicates
  bool light_groups = false;      ///< layers of the light that comes from each of SceneNames::lights
  bool guiding = false;           ///< directions are sampled from what passes before the picture have learned
  std::optional<PixelRect> crop;  ///< default: the scene's, else the whole frame
  /// Called by workers after each task, several at a time, with samples done and in all.
  std::function<void(std::uint64_t done, std::uint64_t total)> on_progress;
  /// Called once by each worker, several at a time, for what Wave::recorder is to be; for benchmarks.
  std::function<RayRecorder*()> make_recorder;
  const std::atomic<bool>* stop = nullptr;  ///< polled between tasks; true ends the render with what there is
  /// What the render goes on from, and takes: of one of the same scene and options, threads and waves apart. Null: it
  /// begins.
  RenderState* resume = nullptr;
  /// Polled between tasks by workers, several at a time; true pauses them all, for on_pause.
  std::function<bool()> wants_pause;
  /// Called while all workers pause, and once at the end, whether all is done or the render was stopped.
  std::function<void(const RenderState&)> on_pause;
  /// Called before on_pause, with what has been counted since the render began or was taken up; without its noise,
  /// which takes longer to tell.
  std::function<void(const RenderReport&)> on_report;
};

/// How noisy a picture is: Film::noise(), or with photons that have reached it picture_noise(). Nothing before any
/// photon was emitted.
std::optional<double> noise_of(const Film& film, const std::optional<SplatFilm>& splats, std::uint64_t photons);

struct RenderResult {
  Film film;
  std::optional<SplatFilm> splats;     ///< light tracing: what photons have added
  std::uint64_t photons = 0;           ///< that were emitted
  AovSet aovs;                         ///< that were asked for
  SceneNames names;                    ///< where the film tells surfaces, what they are called
  std::optional<SampleRange> samples;  ///< where some of the samples were asked for, those, of RenderReport::spp
  RenderReport report;                 ///< without scene file and load times, which the caller knows
  bool interrupted = false;
  std::vector<std::string> warnings;

  /// The picture: Film::to_image(), what photons have added, and which surfaces cover its pixels. Of some of the
  /// samples what joining it with the others needs (see kernels/film/merge.h).
  Image to_image() const;
};

/// Most groups of lights that have layers.
inline constexpr std::size_t kMaxLightGroups = 64;

/// Largest value of RenderOptions::wave_size: slots are 16-bit.
inline constexpr int kMaxWaveSize = 32768;

/// The replicates of so many samples per pixel where none are asked for: see RenderOptions::replicates.
std::uint32_t default_replicates(SamplerKind kind, std::uint64_t samples);

/// Renders. The picture's bits depend on scene, seed and sample count alone, not on threads, wave size or crop.
/// Throws Error (usage) if the crop leaves the frame, a number is out of range, spectral bins are asked for where there
/// are no wavelengths, guiding where there are no paths to be guided, or layers where there are none.
RenderResult render(const Scene& scene, const RenderOptions& options);

}  // namespace sheaf
