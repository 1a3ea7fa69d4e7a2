// Builds the photon maps of a render set by set, and shrinks their radii for progressive photon mapping.
#include "kernels/passes/photon_mapping.h"

#include "core/sampling/rng.h"
#include "scene/materials/list.h"

#include <algorithm>
#include <cmath>

namespace sheaf {

namespace {

/// Number of wavelength sets among which the photons of a map are divided.
constexpr std::uint32_t kWavelengthSets = 32;
/// Maximum of photons emitted per photon to be stored, plus a number that fills small maps too: kMoreEmitted for all
/// sets together, or kMoreEmittedPerPass for each pass of progressive maps.
constexpr std::uint64_t kMaxEmittedPerStored = 64, kMoreEmitted = 1 << 18, kMoreEmittedPerPass = 1 << 16;
/// Radius of the first pass of a progressive map, in units of PhotonMapping::pixel_.
constexpr float kFirstRadius = 5;

/// Van der Corput sequence: each of its prefixes covers [0, 1) evenly.
float radical_inverse(std::uint32_t i) {
  i = i << 16 | i >> 16;
  i = (i & 0x00ff00ffu) << 8 | (i & 0xff00ff00u) >> 8;
  i = (i & 0x0f0f0f0fu) << 4 | (i & 0xf0f0f0f0u) >> 4;
  i = (i & 0x33333333u) << 2 | (i & 0xccccccccu) >> 2;
  i = (i & 0x55555555u) << 1 | (i & 0xaaaaaaaau) >> 1;
  return static_cast<float>(i >> 8) * 0x1p-24f;
}

}  // namespace

bool has_phase_functions(const SceneView& scene) {
  bool any = false;
  for_each_closure([&]<class Closure>(ClosureKind closure, Closure) {
    const int kind = static_cast<int>(closure);
    any = any ||
          (Closure::kInfo.is_phase && scene.materials.buckets.begin[kind + 1] > scene.materials.buckets.begin[kind]);
  });
  return any;
}

std::uint32_t photon_map_sets(const PhotonMappingSettings& settings, ColorMode color, std::uint32_t samples) {
  if (settings.progressive) return samples;
  return color == ColorMode::kSpectral ? std::min(samples, kWavelengthSets) : 1;
}

PhotonMapping::PhotonMapping(const StageContext& context, std::uint32_t samples, int film_side)
    : settings_(context.integrator.photons),
      scene_radius_(context.scene.radius),
      pixel_(context.scene.radius / static_cast<float>(film_side)),
      sets_(photon_map_sets(settings_, context.scene.color, samples)) {
  if (!has_phase_functions(context.scene)) settings_.volume.count = 0;
  if (context.scene.color != ColorMode::kSpectral) return;
  std::uint32_t x = context.sampler.seed, y = 0, z = 0, w = 0;
  hash4(x, y, z, w);
  offset_ = static_cast<float>(x >> 8) * 0x1p-24f;
}

std::uint64_t PhotonMapping::count_of(const PhotonMapSettings& map) const {
  return settings_.progressive ? map.count : (map.count + sets_ - 1) / sets_;
}

float PhotonMapping::first_radius_of(const PhotonMapSettings& map) const {
  return map.radius > 0.0f            ? map.radius
         : map.relative_radius > 0.0f ? map.relative_radius * scene_radius_
                                      : kFirstRadius * pixel_;
}

float PhotonMapping::radius_of(const PhotonMapSettings& map) const {
  return first_radius_of(map) * static_cast<float>(std::sqrt(shrunk_));
}

float PhotonMapping::beam_radius() const {
  // The variance of a one-dimensional blur is proportional to the inverse of its radius.
  return first_radius_of(settings_.volume) * static_cast<float>(shrunk_);
}

std::uint64_t PhotonMapping::emitted_for(const PhotonMapSettings& map, PhotonKind kind, Workers& workers,
                                         PhotonTracing& tracing, const StageContext& context) const {
  const std::uint64_t more = settings_.progressive ? kMoreEmittedPerPass : kMoreEmitted / sets_;
  return photons_to_emit(context, workers, kind, count_of(map), kMaxEmittedPerStored * count_of(map) + more, tracing);
}

PhotonKind PhotonMapping::global_kind() const {
  const bool caustics = settings_.caustic.count > 0;
  switch (settings_.gathering) {
    case PhotonGathering::kAll:
      return caustics ? PhotonKind::kAllButCaustic : PhotonKind::kAll;
    case PhotonGathering::kIndirect:
      return caustics ? PhotonKind::kDiffuse : PhotonKind::kIndirect;
    case PhotonGathering::kFinal:
      return PhotonKind::kAll;
  }
  return PhotonKind::kAll;
}

void PhotonMapping::plan(Workers& workers, PhotonTracing& tracing, const StageContext& context) {
  if (is_planned_) return;
  is_planned_ = true;
  const auto emitted = [&](const PhotonMapSettings& map, PhotonKind kind) {
    return emitted_for(map, kind, workers, tracing, context);
  };
  global_emitted_ = emitted(settings_.global, global_kind());
  caustic_emitted_ = emitted(settings_.caustic, PhotonKind::kCaustic);
  volume_emitted_ = emitted(settings_.volume, PhotonKind::kVolume);
}

void PhotonMapping::make(std::uint32_t index, Set& set, Workers& workers, PhotonTracing& tracing,
                         const StageContext& context) {
  const auto trace = [&](const PhotonMapSettings& map, std::uint64_t emitted, PhotonKind kind) {
    return trace_photons(context, workers, {emitted, radius_of(map), kind, index, 0, count_of(map)}, tracing);
  };
  plan(workers, tracing, context);
  set.global = trace(settings_.global, global_emitted_, global_kind());
  if (settings_.caustic.count > 0) set.caustic = trace(settings_.caustic, caustic_emitted_, PhotonKind::kCaustic);
  set.maps = {set.global.view(), set.caustic.view(), settings_.gathering};
  if (settings_.volume.count > 0) {
    set.volume = trace_volume_photons(context, workers,
                                      {volume_emitted_, radius_of(settings_.volume), PhotonKind::kVolume, index,
                                       beam_radius(), count_of(settings_.volume)},
                                      tracing);
    set.maps.volume = &set.volume;
  }
  report(set, tracing.report);
}

void PhotonMapping::report(const Set& set, RenderReport::Photons& report) {
  RenderReport::Photons::Maps maps;
  if (set.global.size() > 0) maps.global_radius = set.maps.global.radius;
  if (set.caustic.size() > 0) maps.caustic_radius = set.maps.caustic.radius;
  const VolumePhotonMap& points = set.volume.points;
  const PhotonBeamMap& beams = set.volume.beams;
  if (points.size() > 0) maps.volume_radius = points.radius();
  if (beams.size() > 0) maps.beam_radius = beams.radius();
  maps.photons = set.global.size() + set.caustic.size() + points.size() + beams.size();
  maps.bytes = set.global.bytes() + set.caustic.bytes() + points.bytes() + beams.bytes();
  if (report.passes++ == 0) report.first = maps;
  report.last = maps;
}

void PhotonMapping::prepare(std::uint32_t sample, Workers& workers, PhotonTracing& tracing, StageContext& context) {
  const auto set = static_cast<std::uint32_t>(sample % sets_);
  if (offset_ >= 0.0f) {
    const float u = offset_ + radical_inverse(set);
    context.wavelength_sample = u < 1.0f ? u : u - 1.0f;
  }
  // Knaus and Zwicker 2011, equation 10
  for (; settings_.progressive && pass_ < sample; ++pass_)
    shrunk_ *= (pass_ + 1.0 + static_cast<double>(settings_.alpha)) / (pass_ + 2.0);
  if (made_.empty()) made_.resize(settings_.progressive ? 1 : sets_);
  Set& at = made_[settings_.progressive ? 0 : set];
  if (settings_.progressive || !at.is_made) {
    at = {};
    make(set, at, workers, tracing, context);
    at.is_made = true;
  }
  context.gather_from(at.maps);
}

}  // namespace sheaf
