// Stage: medium. Samples whether paths scatter in media or reach the surface hit (PBR 14.2.2), and adds the emission of
// media along the ray. A path that scatters becomes a vertex whose closure is the phase function, and passes the same
// stages as surfaces. Photons store their beams here.
//
// Paths in homogeneous media are processed a tile at a time (kernels/stages/uniform_paths.h). The others diverge, so
// each is processed individually, with its four spectral lanes in one register (kernels/media/medium_tracking.h), and
// those in media with one grid are tracked several at a time.
#include "core/soa/lane_array.h"
#include "kernels/lights/light_weight.h"
#include "kernels/lights/volume_light.h"
#include "kernels/media/density_weights.h"
#include "kernels/media/medium_marching.h"
#include "kernels/photons/light_task.h"
#include "kernels/photons/photon_maps.h"
#include "kernels/stages/light_sample_context.h"
#include "kernels/stages/medium_ray.h"
#include "kernels/stages/route_hits.h"
#include "kernels/stages/segment_mis.h"
#include "kernels/stages/stage_list.h"
#include "kernels/stages/uniform_paths.h"
#include "kernels/wave/add_radiance.h"
#include "kernels/wave/path_time.h"
#include "kernels/wave/stage_timer.h"

namespace sheaf {

namespace {

/// One path in a medium.
struct MediumPath {
  Slot slot;
  RayState<Scalar> ray;
  HitState<Scalar> hit;
  PathState<Scalar> state;
  float scatter_pdf;
  float distance_since_vertex;  ///< see Wave::distance_since_vertex
  float time;                   ///< see kernels/wave/path_time.h
};

/// Emission of the medium towards the path, with its MIS weight.
///
/// Light sampling could have sampled a point at distance t along the ray too. Its pdf is p_V by volume, which is p_V
/// r^2 by solid angle and length. The pdf of the path is that of its direction times that of a collision at t. Both are
/// means over the lanes.
class MediumEmission {
 public:
  MediumEmission(const StageContext& context, const Wave& wave, const MediumPath& path, const MediumRay& ray)
      : scene_(context.scene), path_(path), ray_(ray) {
    const LightStrategy strategy = context.integrator.strategy;
    const bool free = path.scatter_pdf == 0.0f || ray.medium.light == kNone;
    contested_ = !free && strategy == LightStrategy::kMis;
    // Photons do not gather light, and a photon map may contain this emission.
    hidden_ = context.starts_at_lights() || (!free && strategy == LightStrategy::kLightOnly) ||
              is_caustic<Scalar>(context, path.ray.flags, path.scatter_pdf);
    if (hidden_) contested_ = false;
    if (!contested_) return;
    const auto from =
        light_sample_context<Scalar>(path.ray, wave.radiance.row(path.slot).normal, path.distance_since_vertex);
    choice_ = choice_probability<Scalar>(context.scene, from, ray.medium.light) / path.scatter_pdf *
              static_cast<float>(context.candidates);
  }

  /// Whether light sampling could have found this emission.
  bool contested() const { return contested_; }
  Float4 radiance() const { return radiance_; }

  /// Adds the emission at distance `t`. `pdf`: pdf of t in the hero lane, 1/m. `passed`: transmittance since `path`;
  /// both it and `pdf` may be over the hero's transmittance. `collision`: extinction, or its majorant, per lane, 1/m.
  void add(const PathWeights& path, float t, Vec3f p, Float4 passed, Float4 collision, float pdf) {
    if (hidden_) return;
    const Float4 found = path.beta * passed * ray_.coefficients(p).sigma_a * ray_.emission(p) * (1.0f / pdf);
    if (!(max_component(found) > 0.0f)) return;
    const float by_path = lane_mean(scene_, path.r_u * ray_.pdf_ratio(passed * collision * (1.0f / pdf)));
    radiance_ = radiance_ + found * (weight(path, t, p, passed, by_path, pdf) / by_path);
  }

  /// Adds the emission of one step of ray marching, without MIS. `passed`: transmittance
  /// up to the step. `length`: of the step, m.
  void add_step(const PathWeights& path, Float4 passed, const MediumCoefficients& c, Vec3f p, float length) {
    if (hidden_) return;
    const Float4 sigma_t = c.sigma_t;
    const Float4 absorbed = (Float4(1.0f) - transmittance(sigma_t, length)) / max(sigma_t, Float4(1e-30f));
    const Float4 found = path.beta * passed * c.sigma_a * ray_.emission(p) * absorbed;
    radiance_ = radiance_ + found * (1.0f / lane_mean(scene_, path.r_u));
  }

  /// Adds the emission of a homogeneous medium along the whole ray in closed form, without MIS.
  void add_line(const PathWeights& path) {
    if (hidden_) return;
    const MediumCoefficients c = medium_coefficients(ray_.medium, ray_.spectra);
    const Float4 sigma_t = c.sigma_t;
    const Float4 absorbed = Float4(1.0f) - transmittance(sigma_t, ray_.length);
    const Float4 found = path.beta * c.sigma_a * ray_.spectra.emission * absorbed / max(sigma_t, Float4(1e-30f));
    radiance_ = radiance_ + found * (1.0f / lane_mean(scene_, path.r_u));
  }

 private:
  float weight(const PathWeights& path, float t, Vec3f p, Float4 passed, float by_path, float pdf) const {
    if (!contested_) return 1.0f;
    // Light sampling passes homogeneous media with probability 1.
    const Float4 light_pdf = ray_.has(kMediumHomogeneous) ? Float4(1.0f / pdf) : ray_.pdf_ratio(passed * (1.0f / pdf));
    const float r = t + path_.distance_since_vertex;
    const Vec3f in_world = scene_.motion.lights != nullptr ? path_.ray.origin + path_.ray.direction * t : p;
    const float by_light = lane_mean(scene_, path.r_l * light_pdf) * choice_ *
                           volume_light_pdf_at(scene_, ray_.medium.light, in_world, path_.time) * r * r;
    return power_heuristic(by_path, by_light);
  }

  const SceneView& scene_;
  const MediumPath& path_;
  const MediumRay& ray_;
  bool contested_ = false, hidden_ = false;
  /// Pdf of sampling this light instead of the path's direction: selection probability times the number of candidates
  /// over the pdf of the direction.
  float choice_ = 0;
  Float4 radiance_;
};

/// Emission along a homogeneous ray: in closed form if it needs no MIS, otherwise at one sampled point.
void emit_homogeneous(const MediumRay& ray, MediumRandom& random, const PathWeights& weights,
                      MediumEmission& emission) {
  if (!emission.contested()) return emission.add_line(weights);
  const Float4 sigma_t = medium_coefficients(ray.medium, ray.spectra).sigma_t;
  const float sigma = sigma_t[ray.hero];
  if (!(sigma > 0.0f)) return;
  const float t = exponential_distance(sigma, random.next());
  if (!(t < ray.length)) return;
  const Float4 passed = transmittance(sigma_t, t);
  emission.add(weights, t, ray.at(t), passed, sigma_t, sigma * passed[ray.hero]);
}

/// Samples the distance at which the path scatters: by inversion of the transmittance in homogeneous media, otherwise
/// by ray marching or null collisions. Returns the ray's length if the path reaches its end.
float track(const StageContext& context, const MediumRay& ray, float u, MediumRandom& random, TrackingCounts& counts,
            PathWeights& weights, MediumEmission& emission) {
  const bool emits = ray.has(kMediumEmits);
  const MediumEstimator estimator = context.integrator.medium_estimator;
  if (ray.has(kMediumHomogeneous)) {
    if (emits) emit_homogeneous(ray, random, weights, emission);
    const float t = track_homogeneous(ray, u, weights);
    if (t < ray.length) ++counts.real;
    return t;
  }
  const auto emit = [&](const Collision& at, Vec3f p, const PathWeights& before) SHEAF_LAMBDA_INLINE {
    if (emits) emission.add(before, at.t, p, at.passed, at.sigma_maj, at.sigma_maj[ray.hero]);
  };
  if (estimator == MediumEstimator::kMarching) return march(ray, u, random, counts, weights, emission);
  return track_null_collisions(ray, random, estimator == MediumEstimator::kDelta, counts, weights, emit);
}

MediumPath load_path(const SceneView& scene, const Wave& wave, Slot slot) {
  return {slot,
          wave.rays.get(slot),
          wave.hits.get(slot),
          wave.paths.get(slot),
          wave.radiance.row(slot).scatter_pdf,
          wave.distance_since_vertex[slot],
          path_time(scene, wave, slot)};
}

void store_weights(Wave& wave, Slot slot, const PathWeights& weights) {
  wave.paths.row(slot).beta = to_spectrum(weights.beta);
  wave.rescaled_pdfs.row(slot) = {to_spectrum(weights.r_u), to_spectrum(weights.r_l)};
}

/// Turns the path into a vertex in the medium at distance `t`.
void scatter_path(const StageContext& context, Wave& wave, MediumPath& path, const MediumRay& ray, float t) {
  path.hit.t = t;
  path.hit.material = ray.medium.phase;
  path.hit.light = kNone;
  path.hit.shape = 0;  // any valid row: the selection among phase functions reads the surface
  path.hit.instance = kNone;
  wave.hits.set(path.slot, path.hit);
  route_vertices<Scalar>(context, wave, &path.slot, 1u, path.hit.material, path.ray.flags);
}

/// Stores the segment on which a path scatters at distance `t`. `before` and `after`: r_u before and after the distance
/// was sampled.
void store_segment(const SceneView& scene, Wave& wave, const MediumPath& path, const MediumRay& ray,
                   const Spectrum4& before, Float4 after, float t) {
  SegmentState<Scalar>& out = wave.segments.row(path.slot);
  out = {ray.origin, 0.0f, ray.direction, 0.0f};
  if (!connects_segments(ray.medium) || (path.ray.flags & kRayLast) != 0 || path.state.depth() >= kConnectedDepth)
    return;
  const bool homogeneous = ray.has(kMediumHomogeneous);
  const Float4 sigma_t = homogeneous ? medium_coefficients(ray.medium, ray.spectra).sigma_t : Float4();
  const auto part =
      connected_part<Scalar>(scene, ray.medium, ray.origin, ray.direction, ray.length, to_spectrum(sigma_t));
  const float sigma = homogeneous ? sigma_t[ray.hero] : ray.coefficients(ray.at(t)).sigma_t[ray.hero];
  out = scattered_segment<Scalar>(part, ray.origin, ray.direction, t, sigma,
                                  homogeneous ? sigma : ray.medium.mean_extinction,
                                  lane_mean<Scalar>(scene.color, before), lane_mean(scene, after));
}

/// Stores the flight of a photon along `length` meters of the ray as a beam. `r_u`: at its start.
void store_beam(const StageContext& context, Wave& wave, const MediumPath& path, const MediumRay& ray,
                const Spectrum4& r_u, float length) {
  const RadianceState<Scalar>& row = wave.radiance.row(path.slot);
  const float over = 1.0f / lane_mean<Scalar>(context.scene.color, r_u);
  PhotonBeam beam;
  beam.start = ray.origin, beam.direction = ray.direction;
  beam.length = min(length, kLongestBeam);
  beam.power = path.state.beta * (row.weight * over);
  beam.pdf_ratio = r_u * over;
  beam.medium_key = photon_medium_key(path.ray.flags >> kRayMediumShift, path.state.depth() + 1,
                                      has_single_wavelength(context, wave, path.slot));
  beam.order = row.task_sample << kVertexBits | path.state.dimension();
  const Vec3f far = abs(beam.start);
  if (!(max(max(far.x, far.y), far.z) < kLongestBeam) || !(beam.length > 0.0f)) return;
  if (is_finite(max_component(beam.power)) && is_finite(max_component(beam.pdf_ratio))) {
    context.light_task().beams.push_back(beam);
    return;
  }
  ++wave.stats.dropped.samples;
  if (!wave.first_dropped.any) wave.first_dropped = {true, path.state.pixel, path.state.sample};
}

/// Whether the path is a photon that stores beams in the ray's medium, and whose light may still be scattered.
bool leaves_beam(const StageContext& context, const MediumRay& ray, std::uint32_t flags) {
  return context.starts_at_lights() && context.light_task().stores_in_media() && (flags & kRayLast) == 0 &&
         ray.has(kMediumScatters) && keeps_beams(context.integrator.photons, ray.medium);
}

MediumRay ray_of(const StageContext& context, const Wave& wave, const MediumPath& path) {
  const float end =
      path.hit.shape == kNone ? medium_end<Scalar>(context.scene, path.ray.origin, path.ray.direction) : kInfinity;
  return make_medium_ray(context, path.ray.flags, lane_wavelengths(context.scene, wave, path.slot), path.ray.origin,
                         path.ray.direction, min(path.hit.t, end), path.time);
}

PathWeights load_weights(const Wave& wave, const MediumPath& path) {
  const RescaledPdfs<Scalar>& r = wave.rescaled_pdfs.row(path.slot);
  return {Float4(path.state.beta), Float4(r.r_u), Float4(r.r_l)};
}

/// Continues a path that has reached distance `t`: scatters it, or routes it to the surface hit.
void finish_path(const StageContext& context, Wave& wave, MediumPath& path, const MediumRay& ray, float t,
                 PathWeights& weights) {
  if (leaves_beam(context, ray, path.ray.flags))
    store_beam(context, wave, path, ray, wave.rescaled_pdfs.row(path.slot).r_u, t);
  if (!(max_component(weights.beta) > 0.0f)) {
    wave.finished.push(path.slot);
    return;
  }
  if (t < ray.length && wave.needs.segments && connects_segments(context))
    store_segment(context.scene, wave, path, ray, wave.rescaled_pdfs.row(path.slot).r_u, weights.r_u, t);
  weights.rescale();
  store_weights(wave, path.slot, weights);
  if (t < ray.length) return scatter_path(context, wave, path, ray, t);
  const std::uint32_t flags = path.ray.flags;
  route_hits<Scalar>(context, wave, &path.slot, 1u,
                     {path.hit.shape != kNone, path.hit.light, path.hit.material, flags});
}

/// Tracks a single path.
void medium_path(const StageContext& context, Wave& wave, MediumPath& path, const MediumRay& ray, float u,
                 TrackingCounts& counts) {
  MediumRandom random(context.sampler.seed, path.state.pixel, path.state.sample, path.state.dimension(),
                      MediumStream::kPath);
  PathWeights weights = load_weights(wave, path);
  MediumEmission emission(context, wave, path, ray);
  const float t = track(context, ray, u, random, counts, weights, emission);
  if (ray.has(kMediumEmits)) add_radiance(wave, path.slot, emission.radiance(), ray.medium.light, 0);
  finish_path(context, wave, path, ray, t, weights);
}

/// Paths that are tracked several at a time, one per lane.
class DensityPaths {
 public:
  DensityPaths(const StageContext& context, Wave& wave, TrackingCounts& counts)
      : context_(context), wave_(wave), counts_(counts), queue_(context.sampler, MediumStream::kPath) {}

  template <class L> void add(const MediumPath& path, const MediumRay& ray) {
    slots_[static_cast<std::size_t>(queue_.size())] = path.slot;
    queue_.add(ray, path.state.pixel, path.state.sample, path.state.dimension());
    if (queue_.is_full()) finish<L>();
  }

  /// Tracks and continues all queued paths.
  template <class L> void finish() {
    queue_.track<L, DensityTracking::kScattering>();
    const bool delta = context_.integrator.medium_estimator == MediumEstimator::kDelta;
    for (int i = 0; i < queue_.size(); ++i) {
      const MediumRay& ray = queue_.ray(i);
      const TrackResult<Scalar>& end = queue_.end(i);
      MediumPath path = load_path(context_.scene, wave_, slots_[static_cast<std::size_t>(i)]);
      PathWeights weights = load_weights(wave_, path);
      weigh_scattering(ray, end, delta, weights);
      counts_.null += end.nulls;
      const auto outcome = static_cast<DensityOutcome>(end.outcome);
      if (outcome == DensityOutcome::kScattered) ++counts_.real;
      if (outcome == DensityOutcome::kAbandoned) ++counts_.abandoned, weights.beta = Float4();
      finish_path(context_, wave_, path, ray, outcome == DensityOutcome::kScattered ? end.t : ray.length, weights);
    }
    queue_.clear();
  }

 private:
  const StageContext& context_;
  Wave& wave_;
  TrackingCounts& counts_;
  DensityQueue queue_;
  std::array<Slot, DensityQueue::kCapacity> slots_;
};

}  // namespace

template <class L> void medium(const StageContext& context, Wave& wave) noexcept {
  const int paths = wave.medium.size();
  if (paths == 0) return;
  StageTimer timer(wave.stats, stage_named<L>("medium"));
  timer.count(paths, L::width);
  wave.medium.pad();
  TrackingCounts counts;
  DensityPaths by_density(context, wave, counts);
  for_tiles<L>(paths, [&](int i, int count) {
    const Slot* slots = wave.medium.data() + i;
    const std::uint32_t together = track_uniform_tile<L>(context, wave, slots, count, counts);
    LaneArray<Float<L>> u;
    bool is_drawn = false;
    for_each_lane(mask_bits(L::first(count)) & ~together, [&](int lane) {
      MediumPath path = load_path(context.scene, wave, slots[lane]);
      const MediumRay ray = ray_of(context, wave, path);
      if (is_tracked_by_density(ray, context.integrator.medium_estimator) && !ray.has(kMediumEmits)) {
        by_density.add<L>(path, ray);
      } else {
        // Draw the numbers of the tile when its first path needs one
        if (!is_drawn) {
          const PathState<L> state = wave.paths.gather<L>(slots);
          u = LaneArray(
              draw<L>(context.sampler, state.pixel, state.sample, state.dimension(), SampleBlock::kSelect, {}, kNumberY)
                  .y);
          is_drawn = true;
        }
        medium_path(context, wave, path, ray, u[lane], counts);
      }
    });
  });
  by_density.finish<L>();
  wave.stats.collisions += counts;
  wave.medium.clear();
}

SHEAF_INSTANTIATE_STAGE(medium);

}  // namespace sheaf
