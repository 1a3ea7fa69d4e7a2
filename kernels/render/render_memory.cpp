// Estimates the memory of a render from the sizes of its film, tiles, photon maps and waves.
#include "kernels/render/render_memory.h"

#include "kernels/film/cryptomatte.h"
#include "kernels/passes/photon_mapping.h"
#include "kernels/photons/photon.h"
#include "kernels/photons/photon_beam.h"
#include "kernels/photons/photon_map.h"
#include "kernels/render/tiles.h"
#include "kernels/wave/wave.h"

#include <algorithm>
#include <cmath>
#include <thread>

namespace sheaf {

namespace {

/// Bytes of IdCoverage per pixel: the object itself, and one heap block for one or two surfaces.
constexpr double kCoverageBytes = sizeof(IdCoverage) + 48.0;

double area_of(const PixelRect& rect) { return static_cast<double>(rect.width()) * static_cast<double>(rect.height()); }

/// Layout and size of the film per pixel.
struct FilmSize {
  FilmLayout channels;
  FilmRow row;
  double pixels, numbers;  ///< `numbers`: of 8 bytes, per pixel
  double coverage;         ///< bytes per pixel
};

FilmSize film_size(const RenderSettings& settings, const LightGroupLayers& groups) {
  const FilmLayout channels = film_layout(settings.aovs, settings.has_variances, groups.names);
  const FilmRow row(channels, settings.spectral_bins, settings.unit == VarianceUnit::kSample);
  const auto variances = static_cast<double>(row.variances);
  double numbers = 1 + static_cast<double>(row.film_size());
  if (settings.unit == VarianceUnit::kReplicate && variances > 0) numbers += 1 + variances;
  if (channels.half_count() > 0) numbers += 1 + channels.half_count();
  const double coverage = settings.aovs.contains(AovSource::kSurfaceId) ? kCoverageBytes : 0;
  return {channels, row, area_of(settings.crop), numbers, coverage};
}

/// Area of a square of `side` pixels grown by `reach` on each side, over the area of the square.
double spread_of(int side, int reach) { return std::pow(1 + 2.0 * reach / side, 2); }

/// Bytes per pixel of the borders that tiles add to each other. All of them are kept until the pass ends.
double border_bytes(const FilmSize& film, const RenderSettings& settings) {
  if (settings.reach == 0) return 0;
  const int side = tile_side(std::min({kPassSamples, settings.range.count, settings.replicate_samples}));
  return (spread_of(side, settings.reach) - 1) * (8 * static_cast<double>(film.row.size()) + film.coverage);
}

/// Bytes per pixel of the sums of adaptive sampling.
double adaptive_bytes(const FilmSize& film, const RenderSettings& settings) {
  const double sums = 8 * static_cast<double>(1 + film.row.channels + film.row.bins) + film.coverage;
  return AdaptiveFilm::kSets * (sums * spread_of(kAdaptiveSide, settings.reach) + 8 + 16);
}

/// Bytes per pixel of the final image, and of its copy from before the id layers were added.
double image_bytes(const FilmSize& film, const RenderSettings& settings) {
  const double channels =
      film.channels.size() + static_cast<double>(film.row.variances + film.row.bins) + film.channels.half_count() + 1;
  double ids = 0;
  for (const Aov aov : {aov_named("object_id"), aov_named("material_id")}) ids += settings.aovs.contains(aov) ? 1 : 0;
  for (const Aov aov : {aov_named("cryptomatte_object"), aov_named("cryptomatte_material")})
    ids += settings.aovs.contains(aov) ? 2 * kCryptomatteRanks : 0;
  return 4 * (ids > 0 ? 2 * channels + ids : channels);
}

/// Bytes of photons: as traced by the tasks of one map at a time with the keys of their order, and of all maps.
double photon_bytes(const StageContext& context) {
  if (!context.integrator.traits().has_photon_maps()) return 0;
  const PhotonMappingSettings& photons = context.integrator.photons;
  constexpr double kKey = sizeof(std::uint64_t), kSorted = 9 * sizeof(float);
  constexpr double kInBlocks = (sizeof(PhotonBlock) + 1.1 * sizeof(PhotonBlockGroup) / kPhotonBlock) / kPhotonBlock;
  double traced = 0, sorted = 0;
  const auto add = [&](const PhotonMapSettings& map, double of_traced, double of_sorted) {
    traced = std::max(traced, of_traced * static_cast<double>(map.count));
    sorted += of_sorted * static_cast<double>(map.count);
  };
  add(photons.global, sizeof(Photon) + kKey, kInBlocks);
  add(photons.caustic, sizeof(Photon) + kKey, kInBlocks);
  if (has_phase_functions(context.scene)) {
    if (photons.uses_beams())
      add(photons.volume, sizeof(PhotonBeam), sizeof(PhotonBeam));
    else
      add(photons.volume, sizeof(Photon) + kKey, kSorted);
  }
  return traced + sorted;
}

/// Bytes per thread: its wave, the samples of its task, and its tile.
double worker_bytes(const FilmSize& film, const RenderSettings& settings, const WaveSetup& wave) {
  const double sample = 4.0 * film.channels.size() + sizeof(SampleOffset) +
                        (film.row.bins > 0 ? sizeof(SpectralSample) : 0) +
                        (film.coverage > 0 ? sizeof(SurfaceSample) : 0);
  const double side = settings.adapts ? kAdaptiveSide : 64;
  const double tile =
      std::pow(side + 2.0 * settings.reach, 2) * (8 * static_cast<double>(film.row.size()) + film.coverage);
  return static_cast<double>(Wave::bytes_per_path(wave.needs)) * wave.size + kTaskSamples * sample + tile;
}

}  // namespace

int threads_of(const RenderControl& control) {
  return control.threads > 0 ? control.threads : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
}

WaveSetup wave_setup(const Scene& scene, const RenderSettings& settings, const RenderControl& control) {
  const StageContext context(scene, settings.integrator);
  const auto needs_of = [&](WaveNeeds needs) {
    needs.chains = settings.caustics == CausticMode::kManifold;
    needs.guides = needs.guides || !settings.training.empty();
    return needs;
  };
  // The trial is short, so waves have the size that suits the passes of the image
  const WaveNeeds needs = needs_of(WaveNeeds::of(context));
  const int size = control.wave_size > 0 ? control.wave_size : Wave::default_capacity(needs);
  return {settings.compares_candidates ? needs_of(WaveNeeds::with_candidate_moments(context)) : needs, size};
}

std::vector<MemoryUse> render_memory(const Scene& scene, const RenderSettings& settings, const RenderControl& control) {
  const StageContext context(scene, settings.integrator);
  const FilmSize film = film_size(settings, light_group_layers(scene, settings));
  const bool connects_photons = context.integrator.traits().connects_photons();
  const std::string parts = "render it in parts with --crop and merge them with 'sheaf merge'";
  std::vector<MemoryUse> uses{{"the film",
                               film.pixels * (8 * film.numbers + film.coverage + (connects_photons ? 48 : 0)),
                               parts + ", or write fewer layers"}};
  // The image is created after all tiles, but the heap does not release blocks as small as the borders of tiles.
  const double edges = settings.adapts ? adaptive_bytes(film, settings) : border_bytes(film, settings);
  uses.push_back({settings.adapts ? "the sums of adaptive sampling" : "the borders of tiles", film.pixels * edges,
                  parts + ", or write fewer layers"});
  uses.push_back({"the image", film.pixels * image_bytes(film, settings), parts + ", or write fewer layers"});
  if (const double photons = photon_bytes(context); photons > 0)
    uses.push_back({"photon maps", photons, "use fewer photons"});
  uses.push_back({"rays", threads_of(control) * worker_bytes(film, settings, wave_setup(scene, settings, control)),
                  "use fewer --threads or smaller waves (--wave-size)"});
  return uses;
}

}  // namespace sheaf
