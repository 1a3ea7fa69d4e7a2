// Stage: gather volume. With a volume photon map, media do not scatter camera paths. Instead the photons estimate the
// in-scattered radiance along the whole ray (Jarosz, Zwicker and Jensen 2008, "The Beam Radiance Estimate for
// Volumetric Photon Mapping", equation 16):
//     L = sum of T(t_i) p Phi_i k(d_i)
// Photon i lies at distance t_i along the ray and d_i across it. T is the transmittance, p the phase function, and k
// the kernel over the disc of the lookup radius. Photons are stored after scattering, so Phi includes the albedo.
//
// Photons in media whose grids move are kept relative to the grids, as they were stored at any time of the shutter.
//
// Homogeneous media may store beams instead (kernels/stages/gather_beams.h). Transmittance is exact in homogeneous
// media. Other media take one walk of ratio tracking for all photons and for the light from behind the medium.
#include "core/math/frame.h"
#include "core/sampling/octahedral.h"
#include "core/soa/lane_array.h"
#include "kernels/lights/light_weight.h"
#include "kernels/stages/gather_beams.h"
#include "kernels/stages/medium_ray.h"
#include "kernels/stages/route_hits.h"
#include "kernels/stages/stage_list.h"
#include "kernels/wave/add_radiance.h"
#include "kernels/wave/path_time.h"
#include "kernels/wave/stage_timer.h"

#include <algorithm>
#include <optional>

namespace sheaf {

namespace {

/// Finds the photons near the ray that count, in the order of their distance from its origin. `stretch`: length of the
/// ray's direction.
void find_photons(const VolumePhotonMap& map, const MediumRay& ray, float stretch, std::uint32_t medium,
                  std::uint32_t edges_left, BeamScratch& scratch) {
  if (edges_left == 0 || !ray.has(kMediumScatters)) return;
  std::vector<NearPoint>& found = scratch.found;
  found.clear();
  map.points().near_ray(ray.origin, ray.direction * (1.0f / stretch), ray.length * stretch, found);
  const auto counts = [&](const NearPoint& point) {
    const std::uint32_t medium_key = map.photon(point.index).medium_key;
    return (medium_key & kMaxPhotonEdges) <= edges_left && medium_key >> kPhotonMediumShift == medium;
  };
  found.erase(std::remove_if(found.begin(), found.end(), [&](const NearPoint& point) { return !counts(point); }),
              found.end());
  std::sort(found.begin(), found.end(),
            [](const NearPoint& a, const NearPoint& b) { return a.t != b.t ? a.t < b.t : a.index < b.index; });
  for (NearPoint& point : found) {
    point.t *= 1.0f / stretch;
    scratch.photons.push_back({point, {}});
  }
}

/// Emission of the medium along the ray, and transmittance of the whole ray.
struct Passage {
  Float4 emitted, transmittance;
};

/// Passes a homogeneous medium; sets the transmittance of each photon.
Passage pass_homogeneous_medium(const MediumRay& ray, std::vector<NearPhoton>& near) {
  const MediumCoefficients c = medium_coefficients(ray.medium, ray.spectra);
  const Float4 sigma_t = c.sigma_t;
  for (NearPhoton& photon : near) photon.transmittance = to_spectrum(transmittance(sigma_t, photon.point.t));
  const Float4 passed = transmittance(sigma_t, ray.length);
  Float4 emitted;
  if (ray.has(kMediumEmits)) {
    const Float4 absorbed = (Float4(1.0f) - passed) / max(sigma_t, Float4(1e-30f));
    // Without extinction there is no emission either.
    emitted = c.sigma_a * ray.spectra.emission * absorbed;
  }
  return {emitted, passed};
}

/// Passes a heterogeneous medium by ratio tracking against the largest majorant of all lanes, with a weight per lane
/// (Novak, Selle and Jarosz, "Residual Ratio Tracking for Estimating Attenuation in Participating Media", 2014, section
/// 3).
Passage pass_heterogeneous_medium(MediumRay ray, MediumRandom& random, TrackingCounts& counts,
                                  std::vector<NearPhoton>& near) {
  const Float4 majorants = majorant_spectrum(ray, 1.0f);
  for (int lane = 0; lane < 4; ++lane)
    if (majorants[lane] > majorants[ray.hero]) ray.hero = lane;
  Float4 passed(1.0f), emitted;
  std::size_t next = 0;
  const auto reach = [&](float t) {
    for (; next < near.size() && near[next].point.t < t; ++next) near[next].transmittance = to_spectrum(passed);
  };
  const std::uint64_t abandoned = counts.abandoned;
  for_each_collision(ray, random, counts, [&](const Collision& at) {
    reach(at.t);
    ++counts.shadow;
    const Float4 over = Float4(1.0f / at.sigma_maj[ray.hero]);
    const Vec3f p = ray.at(at.t);
    const MediumCoefficients c = ray.coefficients(p);
    if (ray.has(kMediumEmits)) emitted = emitted + passed * c.sigma_a * ray.emission(p) * over;
    passed = passed * max(Float4(1.0f) - c.sigma_t * over, Float4());
    return max_component(passed) > 0.0f;
  });
  if (counts.abandoned != abandoned) passed = Float4();
  reach(kInfinity);
  return {emitted, passed};
}

/// Transform of the grids of a medium from their rest pose to their pose at the time of a ray.
struct GridTransform {
  std::optional<InstancePlacement<Scalar>> moved;  ///< nothing if they are static
  float stretch = 1;                               ///< length of the direction of the ray in the medium

  GridTransform(const SceneView& scene, std::uint32_t medium, float time, const MediumRay& ray) {
    if (scene.motion.media == nullptr || scene.motion.media[medium].segment_count == 0) return;
    moved = medium_motion(scene, medium, time).placed;
    stretch = length(ray.direction);
  }
};

/// Radiance due to the photons. `direction`: of the ray, in world space.
template <class L>
Float4 gather_points(const SceneView& scene, const VolumePhotonMap& map, const MediumRay& ray,
                     const GridTransform& grids, Vec3f direction, bool single_wavelength,
                     const std::vector<NearPhoton>& near) {
  using F = Float<L>;
  const Frame<L> frame = Frame<L>::from_normal(broadcast<L>(-direction));
  Float4 sum;
  for (std::size_t first = 0; first < near.size(); first += L::width) {
    LaneArray<Uint<L>> directions(Uint<L>(0u));
    LaneArray<F> squared(F(0.0f));
    const int count = static_cast<int>(std::min<std::size_t>(L::width, near.size() - first));
    for (int i = 0; i < count; ++i) {
      directions[i] = map.photon(near[first + static_cast<std::size_t>(i)].point.index).direction;
      squared[i] = near[first + static_cast<std::size_t>(i)].point.squared;
    }
    Vec3<L> from = decode_octahedral<L>(directions.load());
    if (grids.moved) {
      const Vec3f* const rows = grids.moved->rows;
      from = normalize(Vec3<L>{dot(broadcast<L>(rows[0]), from), dot(broadcast<L>(rows[1]), from),
                               dot(broadcast<L>(rows[2]), from)});
    }
    const Vec3<L> wi = frame.to_local(from);
    const LaneArray<F> weights(phase_value<L>(scene, ray.medium.phase, wi) *
                               photon_kernel<L>(map.kernel(), squared.load()));
    for (int i = 0; i < count; ++i) {
      const NearPhoton& one = near[first + static_cast<std::size_t>(i)];
      const VolumePhotonMap::Record& photon = map.photon(one.point.index);
      // Path and photon both compensate for lost wavelengths by a factor of 4, which must apply once.
      const bool both = single_wavelength && (photon.medium_key & kPhotonSingleWavelength) != 0;
      sum = sum + Float4(photon.power) * Float4(one.transmittance) * (both ? 0.25f * weights[i] : weights[i]);
    }
  }
  return sum * (kInvPi / (map.radius() * map.radius() * grids.stretch));
}

/// Whether the path adds the emission of the medium along its ray.
bool finds_emission(const StageContext& context, std::uint32_t flags, float scatter_pdf) {
  if (scatter_pdf > 0.0f && context.integrator.strategy == LightStrategy::kLightOnly) return false;
  return !is_caustic<Scalar>(context, flags, scatter_pdf);
}

/// Wavelengths of photons of the same set that still have all four; zeros in RGB mode.
Spectrum4 photon_wavelengths(const StageContext& context, const Wave& wave, Slot slot) {
  if (context.scene.color != ColorMode::kSpectral) return {};
  return sample_wavelengths<Scalar>(std::fabs(wave.wavelength_samples[slot])).lambda;
}

template <class L> void gather_path(const StageContext& context, Wave& wave, Slot slot, TrackingCounts& counts) {
  const SceneView& scene = context.scene;
  const RayState<Scalar> state = wave.rays.get(slot);
  const HitState<Scalar> hit = wave.hits.get(slot);
  PathState<Scalar>& path = wave.paths.row(slot);
  // Find the segment of the ray in the medium
  const float end = hit.shape == kNone ? medium_end<Scalar>(scene, state.origin, state.direction) : kInfinity;
  const MediumRay ray = make_medium_ray(context, state.flags, lane_wavelengths(scene, wave, slot), state.origin,
                                        state.direction, min(hit.t, end), path_time(scene, wave, slot));
  // Find the photons or beams near it
  const auto max_depth = static_cast<std::uint32_t>(context.max_depth);  // -1: larger than any depth
  const std::uint32_t depth = path.depth() + 1;
  const std::uint32_t edges_left =
      max_depth > depth && context.photon_maps().gathers_volume(state.flags) ? max_depth - depth : 0u;
  const PhotonMaps& maps = context.photon_maps();
  const std::uint32_t medium = state.flags >> kRayMediumShift;
  const GridTransform grids(scene, medium - 1, path_time(scene, wave, slot), ray);
  const bool single = has_single_wavelength(context, wave, slot);
  const bool beams = keeps_beams(context.integrator.photons, ray.medium);
  wave.beam.photons.clear();
  if (!beams) find_photons(maps.volume->points, ray, grids.stretch, medium, edges_left, wave.beam);
  // Track the medium for transmittance and emission
  MediumRandom random(context.sampler.seed, path.pixel, path.sample, path.dimension(), MediumStream::kPath);
  const Passage passage = ray.has(kMediumHomogeneous)
                              ? pass_homogeneous_medium(ray, wave.beam.photons)
                              : pass_heterogeneous_medium(ray, random, counts, wave.beam.photons);
  // Add the in-scattered and the emitted radiance
  const Float4 over = Float4(path.beta) * (1.0f / lane_mean<Scalar>(scene.color, wave.rescaled_pdfs.row(slot).r_u));
  const Float4 scattered =
      beams
          ? gather_beams<L>(context, maps.volume->beams, state.flags,
                            {ray, photon_wavelengths(context, wave, slot), single, medium, edges_left}, wave.beam.lines)
          : gather_points<L>(scene, maps.volume->points, ray, grids, state.direction, single, wave.beam.photons);
  wave.stats.volume_gathering += {1, beams ? wave.beam.lines.size() : wave.beam.photons.size()};
  add_radiance(wave, slot, over * scattered, kNone, 1);
  if (ray.has(kMediumEmits) && finds_emission(context, state.flags, wave.radiance.row(slot).scatter_pdf))
    add_radiance(wave, slot, over * passage.emitted, ray.medium.light, 0);
  // Continue the path behind the medium
  path.beta = path.beta * to_spectrum(passage.transmittance);
  if (!(max_component(path.beta) > 0.0f)) {
    wave.finished.push(slot);
    return;
  }
  route_hits<Scalar>(context, wave, &slot, 1u, {hit.shape != kNone, hit.light, hit.material, state.flags});
}

}  // namespace

template <class L> void gather_volume(const StageContext& context, Wave& wave) noexcept {
  const int paths = wave.medium.size();
  if (paths == 0) return;
  StageTimer timer(wave.stats, stage_named<L>("gather_volume"));
  timer.count(paths, 1);
  TrackingCounts counts;
  for (const Slot slot : wave.medium.span()) gather_path<L>(context, wave, slot, counts);
  wave.stats.collisions += counts;
  wave.medium.clear();
}

SHEAF_INSTANTIATE_STAGE(gather_volume);

}  // namespace sheaf
