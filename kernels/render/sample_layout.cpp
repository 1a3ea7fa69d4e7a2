// Validates the options of a render and derives its samples from them.
#include "kernels/render/sample_layout.h"

#include "core/io/error.h"
#include "kernels/passes/photon_mapping.h"
#include "kernels/render/tiles.h"

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

[[noreturn]] void refuse(const std::string& text) { throw Error(ExitCode::kUsage, text); }

PixelRect checked_crop(const Scene& scene, const RenderOptions& options) {
  const FilmSettings& film = scene.film();
  const PixelRect whole{0, 0, film.width, film.height};
  const PixelRect crop = options.crop ? *options.crop : film.crop ? *film.crop : whole;
  if (crop.x0 < 0 || crop.y0 < 0 || crop.x1 > film.width || crop.y1 > film.height || crop.width() <= 0 ||
      crop.height() <= 0)
    throw Error(ExitCode::kUsage, "the crop window must lie inside the frame of " + std::to_string(film.width) + " x " +
                                      std::to_string(film.height) + " pixels");
  return crop;
}

/// Checks that the pixels of the frame and of its border can be numbered by 31 bits.
void check_frame(const FilmSettings& film, const SampledFrame& frame) {
  constexpr std::int64_t kMaxPixels = std::numeric_limits<std::int32_t>::max();
  if (std::int64_t{frame.row_length()} * (film.height + 2 * frame.border) <= kMaxPixels) return;
  refuse("a frame of " + std::to_string(film.width) + " x " + std::to_string(film.height) +
         " pixels is too large (expected at most 2^31 pixels; this limit also applies to renders with a crop window)");
}

void check_spectral_bins(const Scene& scene, int bins) {
  if (bins == 0) return;
  if (bins < 0 || bins > kMaxSpectralBins)
    throw Error(ExitCode::kUsage, "the number of spectral bins must be from 1 to " + std::to_string(kMaxSpectralBins));
  if (scene.color() != ColorMode::kSpectral || !scene.integrator().traits().supports_spectral_bins)
    throw Error(ExitCode::kUsage,
                "spectral bins need spectral mode and an integrator that traces paths from the camera");
}

/// Samples per pixel if the options do not set them.
std::uint32_t default_samples(const Scene& scene) {
  const IntegratorSettings& integrator = scene.integrator();
  const bool passes = integrator.traits().has_photon_maps() && integrator.photons.progressive;
  if (passes && integrator.photons.max_passes > 0) return static_cast<std::uint32_t>(integrator.photons.max_passes);
  return scene.sampler().sample_count;
}

/// Whether layers that come from replicates are requested.
bool wants_halves(const RenderOptions& options) {
  return options.aovs.contains(aov_named("variance")) || options.aovs.contains(aov_named("half"));
}

void check_layers(const RenderOptions& options, const IntegratorSettings& transport, std::uint32_t spp) {
  const bool of_surfaces = options.aovs.contains(AovSource::kVertex) || options.aovs.contains(AovSource::kSurfaceId);
  if ((options.light_groups || of_surfaces) && !transport.traits().follows_camera_paths())
    refuse("surface layers and light groups need an integrator that traces paths from the camera, such as path (got '" +
           transport.name() + "')");
  if (of_surfaces && transport.max_depth == 1) refuse("surface layers need a max depth of at least 2");
  if (options.aovs.contains(aov_named("half")) && transport.traits().connects_photons())
    refuse("the layer half is not available with ptracer, because it needs camera samples");
  if (wants_halves(options) && spp < 2) refuse("the layers variance and half need at least 2 samples per pixel");
}

void check_adaptive(SamplerKind sampler, const IntegratorSettings& transport, std::uint32_t spp) {
  if (sampler != SamplerKind::kSobol && sampler != SamplerKind::kIndependent)
    refuse("a noise target or a time limit needs a sampler without a fixed sample count: sobol or independent");
  if (!transport.traits().supports_adaptive)
    refuse("a noise target or a time limit needs an integrator that traces paths from the camera, such as path (got '" +
           transport.name() + "')");
  if (spp < AdaptiveFilm::kSets) refuse("a noise target or a time limit needs at least 4 samples per pixel");
}

void check_guiding(const IntegratorSettings& integrator) {
  if (can_guide(integrator)) return;
  refuse("guiding needs an integrator that traces paths from the camera, such as path (got '" + integrator.name() +
         "')");
}

/// Manifold next-event estimation replaces BSDF sampling of specular chains behind vertices that sample lights.
void check_caustics(const SceneView& scene, const IntegratorSettings& integrator) {
  if (!can_guide(integrator) || integrator.strategy == LightStrategy::kBsdfOnly)
    refuse(
        "caustics by mnee need an integrator that traces paths from the camera and samples lights, such as path "
        "(got '" +
        integrator.name() + "')");
  if (scene.needs_transmittance)
    refuse(
        "caustics by mnee are not supported in scenes with participating media, masks or thin dielectrics that "
        "shadow rays pass");
}

/// Sets the light groups with layers.
void add_light_groups(const SceneNames& names, const IntegratorSettings& transport, SampleLayout& layout) {
  std::vector<std::string>& groups = layout.light_groups;
  groups = names.lights;
  // Photon maps mix the light of all groups.
  if (names.has_other_light || transport.traits().has_photon_maps()) groups.emplace_back("other");
  if (groups.size() > kMaxLightGroups)
    refuse("the scene has " + std::to_string(groups.size()) + " light groups, expected at most " +
           std::to_string(kMaxLightGroups) +
           "; lights with the same id form one group, and so do lights without an id");
  if (groups.empty()) return;
  for (const std::uint32_t light : names.light_of_row)
    layout.group_of_light.push_back(static_cast<std::uint16_t>(light));
}

/// Sets replicates, halves and the unit of variances.
void set_replicates(const RenderOptions& options, SamplerKind sampler, SampleLayout& layout) {
  std::uint32_t replicates =
      options.replicates > 0 ? static_cast<std::uint32_t>(options.replicates) : default_replicates(sampler, layout.spp);
  if (wants_halves(options)) replicates = std::max(replicates, 2u);
  const bool by_samples = sampler == SamplerKind::kIndependent && layout.reach == 0 && !layout.adapts;
  layout.replicate_samples = by_samples ? layout.spp : (layout.spp + replicates - 1) / replicates;
  const std::uint32_t made = (layout.spp + layout.replicate_samples - 1) / layout.replicate_samples;
  if (options.aovs.contains(aov_named("half")))
    layout.half_samples = by_samples ? layout.spp / 2 : made / 2 * layout.replicate_samples;
  layout.unit = by_samples ? VarianceUnit::kSample : VarianceUnit::kReplicate;
  layout.has_variances = by_samples || layout.adapts || layout.replicate_samples < layout.spp;
}

/// Converts the requested samples to samples of the layout. Throws Error (usage) for an invalid range.
SampleRange requested_range(const SampleRange& requested, const SampleLayout& layout,
                            const IntegratorSettings& transport) {
  const std::string name = std::to_string(requested.first) + ":" + std::to_string(requested.count);
  const std::uint32_t samples = layout.spp / layout.rays;
  if (requested.count == 0 || requested.first >= samples || requested.count > samples - requested.first)
    refuse("the samples " + name + " are out of range (expected samples from 0 to " + std::to_string(samples - 1) +
           " of each pixel)");
  if (transport.traits().connects_photons())
    refuse("sample ranges need an integrator that traces paths from the camera, such as path (got '" +
           transport.name() + "')");
  if (layout.adapts) refuse("sample ranges cannot be combined with a noise target or a time limit");
  const SampleRange range{requested.first * layout.rays, requested.count * layout.rays};
  const std::uint32_t set = layout.replicate_samples;
  const bool is_whole = range.first % set == 0 && (range.end() % set == 0 || range.end() == layout.spp);
  if (is_whole || set == layout.spp) return range;  // a single set may be split anywhere
  const std::string size = std::to_string(set);
  refuse("the samples " + name + " split one of the " + std::to_string((layout.spp + set - 1) / set) +
         " sample sets of " + size + " samples (expected multiples of " + size +
         (layout.rays > 1 ? " gather rays" : "") + "; --replicates changes the sets)");
}

}  // namespace

std::uint32_t default_replicates(SamplerKind kind, std::uint64_t samples) {
  if (kind == SamplerKind::kIndependent) return kFreeReplicates;
  if (samples < kReplicateSamples) return 1;
  return static_cast<std::uint32_t>(std::clamp<std::uint64_t>(samples / kReplicateSamples, 2, kMaxReplicates));
}

SampleLayout make_sample_layout(const Scene& scene, const RenderOptions& options) {
  SampleLayout layout;
  const IntegratorSettings& transport = scene.integrator();
  const SamplerKind sampler = scene.sampler().kind;
  // Set the samples per pixel, with gather rays
  layout.spp = rounded_sample_count(sampler, options.samples_per_pixel.value_or(default_samples(scene)));
  if (transport.traits().has_photon_maps() && transport.photons.gathering == PhotonGathering::kFinal)
    layout.rays = static_cast<std::uint32_t>(transport.photons.gather_rays);
  if (layout.spp > kMaxSamples / layout.rays)
    refuse("samples per pixel times gather rays must not exceed " + std::to_string(kMaxSamples));
  layout.spp *= layout.rays;
  if (layout.spp == 0) refuse("samples per pixel must be at least 1");
  // Check the crop window and the options
  layout.crop = checked_crop(scene, options);
  check_spectral_bins(scene, options.spectral_bins);
  check_layers(options, transport, layout.spp);
  layout.adapts = options.noise_target > 0 || options.time_limit > 0;
  if (layout.adapts) check_adaptive(sampler, transport, layout.spp);

  const FilmSettings& film = scene.film();
  // Determine the sampled pixels
  layout.filter_weights = scene.view().sensor.filter_weights;
  layout.reach = layout.filter_weights != nullptr ? layout.filter_weights->reach() : 0;
  layout.frame = {film.width, film.sample_border ? layout.reach : 0};
  check_frame(film, layout.frame);
  const PixelRect frame_pixels = PixelRect{0, 0, film.width, film.height}.grown(layout.frame.border);
  layout.sampled = layout.crop.grown(layout.reach).intersection(frame_pixels);
  // Divide the samples into replicates and passes
  set_replicates(options, sampler, layout);
  layout.range = options.samples ? requested_range(*options.samples, layout, transport) : SampleRange{0, layout.spp};
  const bool has_map_sets =
      transport.traits().has_photon_maps() && photon_map_sets(transport.photons, scene.color(), layout.spp) > 1;
  layout.max_pass_samples = has_map_sets ? 1 : kPassSamples;
  if (options.light_groups) add_light_groups(scene.names(), transport, layout);
  if (options.guiding == GuidingMode::kOn) check_guiding(transport);
  if (options.caustics == CausticMode::kManifold) check_caustics(scene.view(), transport);
  if (options.wave_size > kMaxWaveSize) refuse("the wave size must not exceed " + std::to_string(kMaxWaveSize));
  return layout;
}

Film SampleLayout::make_film(const Scene& scene, const RenderOptions& options) const {
  return Film(scene.film().width, scene.film().height, crop, film_layout(options.aovs, has_variances, light_groups),
              options.spectral_bins, unit, options.aovs.contains(AovSource::kSurfaceId));
}

}  // namespace sheaf
