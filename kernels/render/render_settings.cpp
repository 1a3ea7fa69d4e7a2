// Validates the request for a render, and derives its samples from it.
#include "kernels/render/render_settings.h"

#include "core/io/error.h"
#include "kernels/film/adaptive_film.h"
#include "kernels/passes/photon_mapping.h"
#include "kernels/render/tiles.h"
#include "scene/scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

namespace sheaf {

namespace {

/// Number of replicates where they cost nothing.
constexpr std::uint32_t kFreeReplicates = 8;

/// Samples per pixel of a replicate where smaller ones are less well stratified. The size is constant so that a render
/// of more samples can continue one of fewer.
constexpr std::uint32_t kReplicateSamples = 32;
constexpr std::uint32_t kMaxReplicates = 16;

/// Maximum of samples per pixel times gather rays.
constexpr std::uint32_t kMaxSamples = 1 << 24;

/// Samples per pixel for which adaptive sampling trains the guide.
constexpr std::uint32_t kTypicalSamples = 64;

/// The quotient, rounded up.
std::uint32_t ceil_div(std::uint32_t dividend, std::uint32_t divisor) { return (dividend + divisor - 1) / divisor; }

[[noreturn]] void refuse(const std::string& text) { throw Error(ExitCode::kUsage, text); }

/// Checks that the pixels of the frame and of its border can be numbered by 31 bits.
void check_frame(const FilmSettings& film, const SampledFrame& frame) {
  constexpr std::int64_t kMaxPixels = std::numeric_limits<std::int32_t>::max();
  if (std::int64_t{frame.row_length()} * (film.height + 2 * frame.border) <= kMaxPixels) return;
  refuse(
      fmt::format("a frame of {} x {} pixels is too large (expected at most 2^31 pixels; this limit also applies to "
                  "renders with a crop window)",
                  film.width, film.height));
}

void check_spectral_bins(const RenderSettings& settings) {
  const int bins = settings.spectral_bins;
  if (bins == 0) return;
  if (bins < 0 || bins > kMaxSpectralBins)
    refuse(fmt::format("the number of spectral bins must be from 1 to {}", kMaxSpectralBins));
  if (settings.color != ColorMode::kSpectral || !settings.integrator.traits().supports_spectral_bins)
    refuse("spectral bins need spectral mode and an integrator that traces paths from the camera");
}

/// Samples per pixel if none are requested.
std::uint32_t default_samples(const SceneSettings& scene) {
  const IntegratorSettings& integrator = scene.integrator;
  const bool passes = integrator.traits().has_photon_maps() && integrator.photons.progressive;
  if (passes && integrator.photons.max_passes > 0) return static_cast<std::uint32_t>(integrator.photons.max_passes);
  return scene.sampler.sample_count;
}

/// Whether layers that come from replicates are requested.
bool wants_halves(const RenderFeatures& features) {
  return features.aovs.contains(aov_named("variance")) || features.aovs.contains(aov_named("half"));
}

void check_layers(const RenderSettings& settings) {
  const IntegratorSettings& transport = settings.integrator;
  const bool of_surfaces = settings.aovs.contains(AovSource::kVertex) || settings.aovs.contains(AovSource::kSurfaceId);
  if ((settings.light_groups || of_surfaces) && !transport.traits().follows_camera_paths())
    refuse(fmt::format(
        "surface layers and light groups need an integrator that traces paths from the camera, such as path (got '{}')",
        transport.name()));
  if (of_surfaces && transport.max_depth == 1) refuse("surface layers need a max depth of at least 2");
  if (settings.aovs.contains(aov_named("half")) && transport.traits().connects_photons())
    refuse("the layer half is not available with ptracer, because it needs camera samples");
  if (wants_halves(settings) && settings.spp < 2)
    refuse("the layers variance and half need at least 2 samples per pixel");
}

void check_adaptive(const RenderSettings& settings) {
  const SamplerKind sampler = settings.sampler.kind;
  const IntegratorSettings& transport = settings.integrator;
  if (sampler != SamplerKind::kSobol && sampler != SamplerKind::kIndependent)
    refuse("a noise target or a time limit needs a sampler without a fixed sample count: sobol or independent");
  if (!transport.traits().supports_adaptive)
    refuse(fmt::format(
        "a noise target or a time limit needs an integrator that traces paths from the camera, such as path (got '{}')",
        transport.name()));
  if (settings.spp < AdaptiveFilm::kSets) refuse("a noise target or a time limit needs at least 4 samples per pixel");
}

void check_guiding(const IntegratorSettings& integrator) {
  if (can_guide(integrator)) return;
  refuse(fmt::format("guiding needs an integrator that traces paths from the camera, such as path (got '{}')",
                     integrator.name()));
}

/// Manifold next-event estimation replaces BSDF sampling of specular chains behind vertices that sample lights.
void check_caustics(const IntegratorSettings& integrator) {
  if (!can_guide(integrator) || integrator.strategy == LightStrategy::kBsdfOnly)
    refuse(
        fmt::format("caustics by mnee need an integrator that traces paths from the camera and samples lights, such as "
                    "path (got '{}')",
                    integrator.name()));
}

void check_clamp(const RenderSettings& settings) {
  const IntegratorTraits& traits = settings.integrator.traits();
  if (settings.clamp_indirect == kInfinity || traits.follows_camera_paths()) return;
  refuse(
      fmt::format("clamping indirect light needs an integrator that traces paths from the camera, such as path (got "
                  "'{}')",
                  settings.integrator.name()));
}

/// Number of sets of samples if none is requested; see RenderRequest::replicates.
std::uint32_t default_replicates(const RenderSettings& settings) {
  if (settings.sampler.kind == SamplerKind::kIndependent) return kFreeReplicates;
  if (settings.spp < kReplicateSamples) return 1;
  return std::clamp(settings.spp / kReplicateSamples, 2u, kMaxReplicates);
}

/// Sets replicates, halves and the unit of variances. `requested`: number of replicates; 0: the default.
void set_replicates(std::uint32_t requested, RenderSettings& settings) {
  settings.requests_replicates = requested > 0;
  settings.replicates = requested > 0 ? requested : default_replicates(settings);
  if (wants_halves(settings)) settings.replicates = std::max(settings.replicates, 2u);
  const bool by_samples = settings.sampler.kind == SamplerKind::kIndependent && settings.reach == 0 && !settings.adapts;
  settings.replicate_samples = by_samples ? settings.spp : ceil_div(settings.spp, settings.replicates);
  const std::uint32_t made = ceil_div(settings.spp, settings.replicate_samples);
  if (settings.aovs.contains(aov_named("half")))
    settings.half_samples = by_samples ? settings.spp / 2 : made / 2 * settings.replicate_samples;
  settings.unit = by_samples ? VarianceUnit::kSample : VarianceUnit::kReplicate;
  settings.has_variances = by_samples || settings.adapts || settings.replicate_samples < settings.spp;
}

/// Sets the requested range of samples. Throws Error (usage) for an invalid range.
void set_range(const std::optional<SampleRange>& requested, RenderSettings& settings) {
  settings.range = {0, settings.spp};
  settings.is_part = requested.has_value();
  if (!requested) return;
  const std::string name = fmt::format("{}:{}", requested->first, requested->count);
  const std::uint32_t samples = settings.camera_samples();
  if (requested->count == 0 || requested->first >= samples || requested->count > samples - requested->first)
    refuse(fmt::format("the samples {} are out of range (expected samples from 0 to {} of each pixel)", name,
                       samples - 1));
  if (settings.integrator.traits().connects_photons())
    refuse(fmt::format("sample ranges need an integrator that traces paths from the camera, such as path (got '{}')",
                       settings.integrator.name()));
  if (settings.adapts) refuse("sample ranges cannot be combined with a noise target or a time limit");
  const SampleRange range{requested->first * settings.rays, requested->count * settings.rays};
  settings.range = range;
  const std::uint32_t set = settings.replicate_samples;
  const bool is_whole = range.first % set == 0 && (range.end() % set == 0 || range.end() == settings.spp);
  if (is_whole || set == settings.spp) return;  // a single set may be split anywhere
  refuse(
      fmt::format("the samples {0} split one of the {1} sample sets of {2} samples (expected multiples of {2}{3}; "
                  "--replicates changes the sets)",
                  name, ceil_div(settings.spp, set), set, settings.rays > 1 ? " gather rays" : ""));
}

/// Sets the samples per pixel, with gather rays.
void set_samples(const std::optional<std::uint32_t>& requested, RenderSettings& settings) {
  const PhotonMappingSettings& photons = settings.integrator.photons;
  const bool has_maps = settings.integrator.traits().has_photon_maps();
  const std::uint32_t samples =
      rounded_sample_count(settings.sampler.kind, requested.value_or(default_samples(settings)));
  if (has_maps && photons.gathering == PhotonGathering::kFinal)
    settings.rays = static_cast<std::uint32_t>(photons.gather_rays);
  if (samples > kMaxSamples / settings.rays)
    refuse(fmt::format("samples per pixel times gather rays must not exceed {}", kMaxSamples));
  if (samples == 0) refuse("samples per pixel must be at least 1");
  settings.sampler.sample_count = samples;
  settings.spp = samples * settings.rays;
  if (has_maps && photons.progressive && settings.spp > kMaxPhotonSets)
    refuse(fmt::format("progressive photon mapping has a pass for each sample per pixel, at most {}", kMaxPhotonSets));
  const bool has_map_sets = has_maps && photon_map_sets(photons, settings.color, settings.spp) > 1;
  settings.max_pass_samples = has_map_sets ? 1 : kPassSamples;
}

/// Sets the pixels of the image and those that are sampled.
void set_pixels(const std::optional<PixelRect>& requested, RenderSettings& settings) {
  const FilmSettings& film = settings.film;
  const PixelRect whole{0, 0, film.width, film.height};
  settings.crop = checked_crop(requested ? *requested : film.crop.value_or(whole), film.width, film.height);
  settings.reach = film.filter_mode == FilterMode::kWeighted ? filter_reach(film.filter) : 0;
  settings.frame = {film.width, film.sample_border ? settings.reach : 0};
  check_frame(film, settings.frame);
  settings.sampled = settings.crop.grown(settings.reach).intersection(whole.grown(settings.frame.border));
}

/// Plans the training passes.
void set_training(RenderSettings& settings) {
  const FilmSettings& film = settings.film;
  if (!trains_guide(settings.guiding, settings.integrator)) return;
  const std::uint32_t samples = settings.adapts ? std::min(settings.spp, kTypicalSamples) : settings.spp;
  settings.training = training_passes(film.width, film.height, samples, settings.guiding);
  settings.compares_candidates = wants_candidate_comparison(settings.integrator, film.width, film.height, samples);
}

}  // namespace

PixelRect checked_crop(const PixelRect& crop, int frame_width, int frame_height) {
  if (!crop.is_empty() && crop.intersection({0, 0, frame_width, frame_height}) == crop) return crop;
  throw Error(ExitCode::kUsage,
              fmt::format("the crop window {},{},{},{} is empty or reaches beyond the frame of {} x {} pixels", crop.x0,
                          crop.y0, crop.x1, crop.y1, frame_width, frame_height));
}

RenderSettings resolve_settings(const SceneSettings& scene, ColorMode color, const RenderRequest& request) {
  RenderSettings settings;
  static_cast<SceneSettings&>(settings) = scene;
  static_cast<RenderFeatures&>(settings) = request;
  settings.color = color;
  settings.sampler.seed = request.seed.value_or(scene.sampler.seed);
  settings.adapts = request.noise_target > 0 || request.time_limit > 0;
  set_samples(request.samples_per_pixel, settings);
  set_pixels(request.crop, settings);
  // Check the features
  check_spectral_bins(settings);
  check_layers(settings);
  if (settings.adapts) check_adaptive(settings);
  if (settings.guiding == GuidingMode::kOn) check_guiding(settings.integrator);
  if (settings.caustics == CausticMode::kManifold) check_caustics(settings.integrator);
  check_clamp(settings);
  // Divide the samples into replicates and passes
  set_replicates(static_cast<std::uint32_t>(std::max(request.replicates, 0)), settings);
  set_range(request.samples, settings);
  set_training(settings);
  return settings;
}

RenderSettings resolve_settings(const Scene& scene, const RenderRequest& request) {
  return resolve_settings({scene.film(), scene.sampler(), scene.integrator()}, scene.color(), request);
}

RenderSettings with_replicates(const RenderSettings& settings, std::uint32_t replicates) {
  RenderSettings changed = settings;
  set_replicates(replicates, changed);
  const SampleRange samples{settings.range.first / settings.rays, settings.range.count / settings.rays};
  set_range(settings.is_part ? std::optional(samples) : std::nullopt, changed);
  return changed;
}

RenderSettings with_adaptive_sampling(const RenderSettings& settings) {
  RenderSettings changed = settings;
  changed.adapts = true;
  set_training(changed);
  return with_replicates(changed, settings.requests_replicates ? settings.replicates : 0);
}

std::uint32_t replicates_for_parts(const RenderSettings& settings, std::uint32_t parts) {
  if (settings.replicates == 1 || settings.requests_replicates) return settings.replicates;
  const std::uint32_t samples = settings.camera_samples();
  const std::uint32_t sets = ceil_div(settings.replicates, parts) * parts;
  if (sets <= samples && ceil_div(samples, ceil_div(samples, sets)) >= parts) return sets;
  return ceil_div(samples, samples / parts);
}

std::vector<SampleRange> divide_samples(const RenderSettings& settings, std::uint32_t parts) {
  const std::uint32_t total = settings.spp, rays = settings.rays;
  // A single set may be split anywhere
  const std::uint32_t set = settings.replicate_samples < total ? settings.replicate_samples : rays;
  const std::uint64_t sets = ceil_div(total, set);
  if (sets < parts) refuse(fmt::format("{} sample sets (--replicates) cannot be divided among {} parts", sets, parts));
  std::vector<SampleRange> ranges;
  std::uint32_t first = 0;
  for (std::uint32_t part = 1; part <= parts; ++part) {
    const auto end = static_cast<std::uint32_t>(std::min<std::uint64_t>(part * sets / parts * set, total));
    if (end % rays != 0)
      refuse(
          fmt::format("a sample set of {} gather rays does not consist of whole samples of {} rays: choose another "
                      "--replicates or --spp",
                      set, rays));
    ranges.push_back({first / rays, (end - first) / rays});
    first = end;
  }
  return ranges;
}

void check_scene(const Scene& scene, const RenderSettings& settings) {
  if (settings.caustics == CausticMode::kManifold && scene.view().needs_transmittance)
    refuse(
        "caustics by mnee are not supported in scenes with participating media, masks or thin dielectrics that "
        "shadow rays pass");
}

}  // namespace sheaf
