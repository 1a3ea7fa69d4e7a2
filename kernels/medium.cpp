// Stage: medium. Paths whose rays lie in a medium scatter in it, or go on to what their rays hit; and collect what the
// medium emits on the way. A path that scatters becomes a vertex whose closure is the phase function, and goes through
// the same stages as surfaces.
//
// Paths go separate ways here, so each has its four spectral lanes in one register; see kernels/medium_tracking.h.
#include "core/octahedral.h"
#include "kernels/light_select.h"
#include "kernels/light_weight.h"
#include "kernels/medium_marching.h"
#include "kernels/medium_ray.h"
#include "kernels/route_hits.h"
#include "kernels/stage_timer.h"
#include "kernels/stages.h"
#include "kernels/volume_light.h"

namespace sheaf {

namespace {

/// One path in a medium.
struct MediumPath {
  Slot slot;
  RayState<Scalar> ray;
  HitState<Scalar> hit;
  ThroughputState<Scalar> throughput;
  float scatter_pdf;
  float travelled;  ///< see Wave::travelled
};

/// Light that the medium emits towards the path.
///
/// A point at distance t along the ray could as well have been sampled as a light: in volume, density p_V, which is
/// p_V r^2 in solid angle times length. Against it stands the path's own density: that of its direction times that of
/// a collision at t. Both count in the mean over the lanes, as everything else does.
class Glow {
 public:
  Glow(const SceneView& scene, const Wave& wave, const MediumPath& path, const MediumRay& ray)
      : scene_(scene), path_(path), ray_(ray) {
    const LightStrategy strategy = scene.integrator.strategy;
    const bool free = path.scatter_pdf == 0.0f || ray.medium.light == kNone;
    contested_ = !free && strategy == LightStrategy::kMis;
    hidden_ = !free && strategy == LightStrategy::kLightOnly;
    if (!contested_) return;
    const Vec3f x = path.ray.origin - path.ray.direction * path.travelled;
    const Vec3f n = path.ray.flags & kRayFromMedium
                        ? Vec3f{}
                        : decode_octahedral<Scalar>(float_bits(wave.radiance.row(path.slot)[5]));
    choice_ = choice_probability<Scalar>(scene, {x, n}, ray.medium.light) / path.scatter_pdf *
              static_cast<float>(scene.integrator.candidates);
  }

  /// Light sampling could have found what the path finds.
  bool contested() const { return contested_; }
  Quad radiance() const { return radiance_; }

  /// Adds what is emitted at distance `t`, whose density is `pdf` in the hero lane: `passed` is the transmittance up to
  /// there since `path`, `collision` the lanes' densities of a collision there without it; both over the hero's.
  void add(const PathWeights& path, float t, Vec3f p, Quad passed, Quad collision, float pdf) {
    if (hidden_) return;
    const Quad found = path.beta * passed * ray_.coefficients(p).sigma_a * ray_.emission(p) * (1.0f / pdf);
    if (!(max_component(found) > 0.0f)) return;
    const float by_path = lane_mean(scene_, path.r_u * ray_.odds(passed * collision * (1.0f / pdf)));
    radiance_ = radiance_ + found * (weight(path, t, p, passed, by_path, pdf) / by_path);
  }

  /// Adds what a step of ray marching emits, which light sampling does not look for; `passed` is the transmittance up
  /// to the step.
  void add_step(const PathWeights& path, Quad passed, const MediumCoefficients& c, Vec3f p, float length) {
    if (hidden_) return;
    const Quad sigma_t = c.sigma_t;
    const Quad absorbed = (Quad(1.0f) - transmittance(sigma_t, length)) / max(sigma_t, Quad(1e-30f));
    const Quad found = path.beta * passed * c.sigma_a * ray_.emission(p) * absorbed;
    radiance_ = radiance_ + found * (1.0f / lane_mean(scene_, path.r_u));
  }

  /// Adds what a homogeneous medium emits over the whole of the ray: exact, with no rival.
  void add_line(const PathWeights& path) {
    if (hidden_) return;
    const MediumCoefficients c = medium_coefficients(ray_.medium, ray_.spectra);
    const Quad sigma_t = c.sigma_t;
    const Quad absorbed = Quad(1.0f) - transmittance(sigma_t, ray_.length);
    const Quad found = path.beta * c.sigma_a * ray_.spectra.emission * absorbed / max(sigma_t, Quad(1e-30f));
    radiance_ = radiance_ + found * (1.0f / lane_mean(scene_, path.r_u));
  }

 private:
  float weight(const PathWeights& path, float t, Vec3f p, Quad passed, float by_path, float pdf) const {
    if (!contested_) return 1.0f;
    // Light sampling passes homogeneous media with probability one.
    const Quad on_the_way = ray_.has(kMediumHomogeneous) ? Quad(1.0f / pdf) : ray_.odds(passed * (1.0f / pdf));
    const float r = t + path_.travelled;
    const float by_light =
        lane_mean(scene_, path.r_l * on_the_way) * choice_ * volume_light_pdf(scene_, ray_.medium.light, p) * r * r;
    return power_heuristic(by_path, by_light);
  }

  const SceneView& scene_;
  const MediumPath& path_;
  const MediumRay& ray_;
  bool contested_ = false, hidden_ = false;
  float choice_ = 0;  ///< of this light by light sampling, over the density of the path's direction
  Quad radiance_;
};

/// Emission along a homogeneous ray: all of it where nothing else could have found it, else at one sampled point.
void glow_homogeneous(const MediumRay& ray, MediumRandom& random, const PathWeights& weights, Glow& glow) {
  if (!glow.contested()) return glow.add_line(weights);
  const Quad sigma_t = medium_coefficients(ray.medium, ray.spectra).sigma_t;
  const float sigma = sigma_t[ray.hero];
  if (!(sigma > 0.0f)) return;
  const float t = exponential_distance(sigma, random.next());
  if (!(t < ray.length)) return;
  const Quad passed = transmittance(sigma_t, t);
  glow.add(weights, t, ray.at(t), passed, sigma_t, sigma * passed[ray.hero]);
}

/// The distance at which the path scatters, or the ray's length.
float track(const SceneView& scene, const MediumRay& ray, float u, MediumRandom& random,
            TrackingCounts& counts, PathWeights& weights, Glow& glow) {
  const bool emits = ray.has(kMediumEmits);
  const MediumEstimator estimator = scene.integrator.medium_estimator;
  if (ray.has(kMediumHomogeneous)) {
    if (emits) glow_homogeneous(ray, random, weights, glow);
    const float t = track_homogeneous(ray, u, weights);
    if (t < ray.length) ++counts.real;
    return t;
  }
  const auto emit = [&](const Collision& at, Vec3f p, const PathWeights& before) SHEAF_LAMBDA_INLINE {
    if (emits) glow.add(before, at.t, p, at.passed, at.sigma_maj, at.sigma_maj[ray.hero]);
  };
  if (estimator == MediumEstimator::kMarching) return march(ray, u, random, counts, weights, glow);
  return track_null_collisions(ray, random, estimator == MediumEstimator::kDelta, counts, weights, emit);
}

MediumPath load_path(const Wave& wave, Slot slot) {
  return {slot, wave.rays.get(slot), wave.hits.get(slot), wave.throughput.get(slot), wave.radiance.row(slot)[4],
          wave.travelled[slot]};
}

void store_weights(Wave& wave, Slot slot, const PathWeights& weights) {
  weights.beta.store(wave.throughput.row(slot));
  weights.r_u.store(wave.probabilities.row(slot));
  weights.r_l.store(wave.probabilities.row(slot) + 4);
}

/// The path becomes a vertex in the medium, at distance `t`.
void scatter_path(const SceneView& scene, Wave& wave, MediumPath& path, const MediumRay& ray, float t) {
  path.hit.t = t;
  path.hit.material = ray.medium.phase;
  path.hit.light = kNone;
  path.hit.shape = 0;  // one that there is: what chooses among phase functions looks at the surface
  path.hit.instance = kNone;
  wave.hits.set(path.slot, path.hit);
  if ((path.ray.flags & kRayLast) != 0) {
    wave.finished.push(path.slot);
  } else if ((scene.materials[ray.medium.phase].flags & kComposite) != 0) {
    wave.composite.push(path.slot);
  } else {
    wave.surface.push(path.slot);
  }
}

void medium_path(const SceneView& scene, Wave& wave, Slot slot, float u, TrackingCounts& counts) {
  MediumPath path = load_path(wave, slot);
  MediumRandom random(scene.sampler.seed, path.throughput.pixel, path.throughput.sample, path.throughput.event(),
                      MediumStream::kPath);
  const MediumRay ray = make_medium_ray(scene, path.ray.flags, lane_wavelengths(scene, wave, slot), path.ray.origin,
                                        path.ray.direction, path.hit.t);
  const float* r = wave.probabilities.row(slot);
  PathWeights weights{Quad(path.throughput.beta), Quad::load(r), Quad::load(r + 4)};
  Glow glow(scene, wave, path, ray);
  const float t = track(scene, ray, u, random, counts, weights, glow);
  if (ray.has(kMediumEmits)) {
    float* radiance = wave.radiance.row(slot);
    (Quad::load(radiance) + glow.radiance()).store(radiance);
  }
  if (!(max_component(weights.beta) > 0.0f)) {
    wave.finished.push(slot);
    return;
  }
  weights.rescale();
  store_weights(wave, slot, weights);
  if (t < ray.length) return scatter_path(scene, wave, path, ray, t);
  const std::uint32_t flags = path.ray.flags;
  route_hits<Scalar>(scene, wave, &slot, 1u, {path.hit.shape != kNone, path.hit.light, path.hit.material, flags});
}

}  // namespace

template <class L> void medium(const SceneView& scene, Wave& wave) noexcept {
  const int paths = wave.medium.size();
  if (paths == 0) return;
  StageTimer timer(wave.stats, Stage::kMedium);
  timer.count(paths, 1);
  wave.medium.pad();
  TrackingCounts counts;
  for_tiles<L>(paths, [&](int i, int count) {
    const Slot* slots = wave.medium.data() + i;
    const ThroughputState<L> path = wave.throughput.gather<L>(slots);
    alignas(kSimdAlignment) float u[L::width];
    store(u, draw<L>(scene.sampler, path.pixel, path.sample, path.event(), SampleBlock::kSelect).y);
    for (int lane = 0; lane < count; ++lane) medium_path(scene, wave, slots[lane], u[lane], counts);
  });
  wave.stats.collisions += counts;
  wave.medium.clear();
}

SHEAF_INSTANTIATE_STAGE(medium);

}  // namespace sheaf
