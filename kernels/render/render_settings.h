// The settings of a render: resolved once from the settings of the scene and what the caller requests, with all checks
// and defaults, and constant from there on. Passes and previews that need others derive a value of their own.
#pragma once

#include "core/color/spectrum.h"
#include "core/image/pixel_rect.h"
#include "kernels/film/aovs.h"
#include "kernels/film/camera_task.h"
#include "kernels/film/film.h"
#include "kernels/render/caustic_mode.h"
#include "kernels/render/sample_division.h"
#include "kernels/training/training_passes.h"
#include "scene/tables/render_settings.h"

#include <optional>
#include <vector>

namespace sheaf {

class Scene;

/// Properties of a render that scenes do not set.
struct RenderFeatures {
  int spectral_bins = 0;  ///< see Film; only in spectral mode
  /// Adaptive sampling: samples every tile until its noise falls below this value (see AdaptiveGoal), or until it has
  /// all samples. 0: all pixels get the same number of samples.
  double noise_target = 0;
  /// Seconds after which no more samples are started, once every tile has some. 0: no limit. The image then depends on
  /// the machine.
  double time_limit = 0;
  AovSet aovs;                ///< further layers; "variance" and "half" need two replicates or more
  bool light_groups = false;  ///< layers with the contribution of each of SceneNames::lights
  /// Path guiding, with training passes before the image is rendered. They also choose the number of light candidates
  /// unless the scene sets it, see wants_candidate_comparison().
  GuidingMode guiding = GuidingMode::kOff;
  /// How paths find caustics. kManifold requires an integrator of paths, next-event estimation, and a scene without
  /// participating media, transparent surfaces and motion.
  CausticMode caustics = CausticMode::kSampled;
  /// Largest contribution of indirect light to a sample, W/(m^2 sr), as the mean over its channels. Larger ones are
  /// scaled down to it: there are no fireflies, but light is lost. Indirect light has been scattered at least twice.
  float clamp_indirect = kInfinity;
};

/// What a caller requests of a render. Empty: as the scene sets it, or the default.
struct RenderRequest : RenderFeatures {
  std::optional<std::uint32_t> samples_per_pixel;
  std::optional<std::uint32_t> seed;
  /// Number of independent sets of samples (replicates), whose spread gives the variance. More sets estimate it better
  /// and are stratified less well: the squared error grows by some 5 % with 2 sets of 16 samples, and by 10 to 20 %
  /// with 4. 1: the image has variances only if samples are independent anyway and contribute to one pixel. 0:
  /// default_replicates().
  int replicates = 0;
  /// The samples of each pixel to be taken. They are the same as in a full render: merging the images of all parts
  /// gives the image of all samples. Default: all.
  std::optional<SampleRange> samples;
  std::optional<PixelRect> crop;  ///< default: that of the scene, otherwise the whole frame
};

/// The resolved settings. SampleDivision counts gather rays as samples.
struct RenderSettings : SceneSettings, RenderFeatures, SampleDivision {
  ColorMode color = ColorMode::kRgb;
  PixelRect crop;  ///< pixels of the image
  /// Pixels that are sampled: the crop, and surrounding pixels whose samples contribute to it.
  PixelRect sampled;
  int reach = 0;  ///< distance up to which samples contribute to other pixels, pixels
  SampledFrame frame;
  std::uint32_t rays = 1;            ///< gather rays per camera sample, each counted as a sample of its own
  std::uint32_t replicates = 1;      ///< requested or default number of sets of samples
  bool requests_replicates = false;  ///< that number was requested
  bool is_part = false;              ///< a range of samples was requested
  bool adapts = false;               ///< adaptive sampling
  VarianceUnit unit = VarianceUnit::kReplicate;
  bool has_variances = false;
  std::vector<TrainingPass> training;  ///< of the guide; empty: paths are not guided
  bool compares_candidates = false;    ///< the first training passes compare numbers of light candidates

  /// Camera samples per pixel.
  std::uint32_t camera_samples() const { return spp / rays; }
};

/// Throws Error (usage) for numbers out of range, a crop beyond the frame, and for what the integrator, the sampler or
/// the color mode does not allow.
RenderSettings resolve_settings(const SceneSettings& scene, ColorMode color, const RenderRequest& request);
RenderSettings resolve_settings(const Scene& scene, const RenderRequest& request = {});

/// The same settings with another number of sets of samples. Throws Error (usage) if a range of samples splits a set.
RenderSettings with_replicates(const RenderSettings& settings, std::uint32_t replicates);

/// The same settings with adaptive sampling, as with a time limit.
RenderSettings with_adaptive_sampling(const RenderSettings& settings);

/// Number of replicates whose sets of samples can be divided among `parts` parts: the requested number, or else at
/// least the default one. `parts` must not exceed the camera samples.
std::uint32_t replicates_for_parts(const RenderSettings& settings, std::uint32_t parts);

/// Divides the camera samples into a range of whole sets for each part, see RenderRequest::samples. Throws Error
/// (usage) if there are fewer sets than parts, or if the sets do not consist of whole camera samples.
std::vector<SampleRange> divide_samples(const RenderSettings& settings, std::uint32_t parts);

/// Throws Error (usage) if `crop` is empty or reaches beyond the frame; otherwise returns it.
PixelRect checked_crop(const PixelRect& crop, int frame_width, int frame_height);

/// Throws Error (usage) if the compiled scene cannot be rendered with the settings.
void check_scene(const Scene& scene, const RenderSettings& settings);

}  // namespace sheaf
