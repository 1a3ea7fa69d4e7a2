// Tracking: where along a ray a path meets its medium, and how much of the light passes.
//
// Distances are sampled by the extinction of one lane of four, the hero; what the others would have made of the same
// path is kept in r_u and r_l, and light that is found counts with the mean of those probabilities: no lane is picked
// blindly (Miller, Georgiev and Jarosz 2019, "A Null-Scattering Path Integral Formulation of Light Transport", sections
// 5.1 and 6; the rescaled form of Pharr et al. 2023, section 14.2.2). Where that is not wanted (MediumRay::weighted)
// the hero is the lane of the largest extinction, and all lanes are taken to have its probabilities. Homogeneous media
// are sampled in closed form and their transmittance is exact: there light sampling passes with probability one.
#pragma once

#include "core/stats.h"
#include "kernels/media/density_tracking.h"
#include "scene/tables/medium_lookup.h"

namespace sheaf {

/// A path on its way: throughput and RescaledPdfs in registers.
struct PathWeights {
  Float4 beta, r_u, r_l;

  /// Takes out a common factor, which means nothing, before lanes far apart overflow.
  void rescale() {
    constexpr float kLarge = 1e6f;
    const float most = max_component(r_u);
    if (!(most > kLarge)) return;
    const float factor = 1.0f / most;
    beta = beta * factor;
    r_u = r_u * factor;
    r_l = r_l * factor;
  }
};

/// Longer than any scene, short enough that products with coefficients stay finite.
inline constexpr float kLongestStretch = 1e18f;

/// A stretch of a ray within one medium.
struct MediumRay {
  const SceneView& scene;
  const MediumRow& medium;
  MediumSpectra spectra;    ///< along this ray, where the medium's extinction depends on the direction
  Spectrum4 lambda;         ///< the path's wavelengths
  Vec3f origin, direction;  ///< world space; unit length
  float length;             ///< metres, at most kLongestStretch
  int hero;                 ///< lane by which distances are sampled
  bool weighted;            ///< the other lanes have probabilities of their own

  Vec3f at(float t) const { return origin + direction * t; }
  bool has(std::uint32_t flag) const { return (medium.flags & flag) != 0; }
  MediumCoefficients coefficients(Vec3f p) const {
    MediumCoefficients c = medium_coefficients(scene, medium, spectra, p, lambda);
    if (!has(kMediumFlakes)) [[likely]]
      return c;
    const float share = flake_share(scene, medium, p, direction);
    return {c.sigma_a * share, c.sigma_s * share, c.sigma_t * share};
  }
  Float4 emission(Vec3f p) const { return medium_emission(scene, medium, spectra, p, lambda); }
  /// What the lanes' probabilities grow by where the throughput was divided by the hero's.
  Float4 odds(Float4 ratio) const { return weighted ? ratio : Float4(ratio[hero]); }
};

using TrackingCounts = Stats::Collisions;

/// Transmittance over a distance in metres.
SHEAF_INLINE Float4 transmittance(Float4 sigma_t, float distance) { return exp(sigma_t * -distance); }

/// A distance by the extinction `sigma` > 0 from u in [0, 1).
SHEAF_INLINE float exponential_distance(float sigma, float u) { return -std::log1p(-u) / sigma; }

/// Samples whether and where the path scatters in a homogeneous medium by u in [0, 1). Returns the distance, or the
/// ray's length where it passes.
inline float track_homogeneous(const MediumRay& ray, float u, PathWeights& path) {
  const MediumCoefficients c = medium_coefficients(ray.medium, ray.spectra);
  const Float4 sigma_t = c.sigma_t;
  if (!ray.has(kMediumScatters)) {
    path.beta = path.beta * transmittance(sigma_t, ray.length);
    return ray.length;
  }
  const float sigma = sigma_t[ray.hero];
  const float t = sigma > 0.0f ? exponential_distance(sigma, u) : kInfinity;
  if (t < ray.length) {
    const Float4 passed = transmittance(sigma_t, t);
    const Float4 ratio = passed * (1.0f / (passed[ray.hero] * sigma));
    path.beta = path.beta * ratio * c.sigma_s;
    path.r_u = path.r_u * ray.odds(ratio * sigma_t);
    return t;
  }
  const Float4 passed = transmittance(sigma_t, ray.length);
  const float p = passed[ray.hero];
  const Float4 ratio = passed * (1.0f / p);
  path.beta = path.beta * ratio;
  path.r_u = path.r_u * ray.odds(ratio);
  path.r_l = path.r_l * (1.0f / p);
  return ray.length;
}

/// The majorant of all lanes where the grid's bound on what multiplies the medium's spectra is `bound`.
SHEAF_INLINE Float4 majorant_spectrum(const MediumRay& ray, float bound) {
  const Float4 most = ray.has(kMediumAbsorptionScattering) ? ray.spectra.first + ray.spectra.second : ray.spectra.first;
  return most * bound;
}

/// The bound that a walk through the majorants has at a point.
inline float majorant_at(const MajorantGridRow& row, Vec3f p) {
  if (row.bounds == nullptr || !is_in_box(row, p)) return row.outside;
  bool hits;
  const LeafWalk<Scalar> walk = start_leaf_walk<Scalar>(row, p, {1, 1, 1}, 0.0f, kInfinity, hits);
  return find_leaf<Scalar>(row, walk).majorant;
}

/// Each lane's density per metre of what MediumEmission counts as a collision at `p`, without the transmittance up to
/// there.
inline Float4 collision_density(const MediumRay& ray, Vec3f p) {
  if (ray.has(kMediumHomogeneous)) return ray.odds(medium_coefficients(ray.medium, ray.spectra).sigma_t);
  return ray.odds(majorant_spectrum(ray, majorant_at(ray.scene.majorant_grids[ray.medium.majorants], p)));
}

/// A tentative collision with a medium that is filled up to its majorant.
struct Collision {
  float t;           ///< metres from the ray's origin
  Float4 sigma_maj;  ///< the majorant there, per metre; the hero's is positive
  Float4 passed;     ///< transmittance of the majorant since the last collision, over the hero's
};

/// Calls collide(Collision) at each tentative collision, nearest first, until it returns false. Returns the
/// transmittance of the majorant from the last collision to the ray's end, over the hero's; zero after kMaxCollisions.
template <class Collide>
SHEAF_INLINE Float4 for_each_collision(const MediumRay& ray, MediumRandom& random, TrackingCounts& counts,
                                       Collide&& collide) {
  const bool grey = ray.has(kMediumGrey);
  std::uint32_t collisions_left = kMaxCollisions;
  // The optical depth of the hero lane that is left until the next collision.
  float depth = detail::exponential<Scalar>(random.next());
  MajorantWalk walk(ray.scene.majorant_grids[ray.medium.majorants], ray.origin, ray.direction, 0.0f, ray.length);
  MajorantSegment segment;
  Float4 passed(1.0f);
  while (walk.next(segment)) {
    const Float4 sigma_maj = majorant_spectrum(ray, segment.bound);
    const float sigma = sigma_maj[ray.hero];
    for (float t = segment.t0;;) {
      const float left = segment.t1 - t;
      const bool collides = sigma * left > depth;
      const float step = collides ? depth / sigma : left;
      if (!grey) passed = passed * exp((Float4(sigma) - sigma_maj) * step);
      if (!collides) {
        depth -= sigma * left;
        break;
      }
      t += step;
      if (!collide(Collision{t, sigma_maj, passed})) return passed;
      if (--collisions_left == 0) {
        ++counts.abandoned;
        return Float4();
      }
      passed = Float4(1.0f);
      depth = detail::exponential<Scalar>(random.next());
    }
  }
  return passed;
}

/// Samples whether and where the path scatters in a heterogeneous medium. Absorption is a factor, not an event. `emit`
/// is called with each tentative collision before anything else, and the path as it was before it. Returns the
/// distance, or the ray's length where the path passes.
template <class Emit>
inline float track_null_collisions(const MediumRay& ray, MediumRandom& random, bool delta, TrackingCounts& counts,
                                   PathWeights& path, Emit&& emit) {
  float scattered_at = -1.0f;
  const Float4 rest = for_each_collision(ray, random, counts, [&](const Collision& at) {
    const Vec3f p = ray.at(at.t);
    emit(at, p, path);
    const MediumCoefficients c = ray.coefficients(p);
    // Majorants hold up to rounding: more than them counts as them.
    const Float4 sigma_t = min(c.sigma_t, at.sigma_maj);
    const float hero = sigma_t[ray.hero], majorant = at.sigma_maj[ray.hero];
    if (random.next() * majorant < hero) {
      ++counts.real;
      const Float4 ratio = at.passed * (1.0f / hero);
      path.beta = path.beta * ratio * c.sigma_s;
      path.r_u = path.r_u * ray.odds(ratio * sigma_t);
      scattered_at = at.t;
      return false;
    }
    ++counts.null;
    const Float4 sigma_n = at.sigma_maj - sigma_t;
    const Float4 ratio = at.passed * (1.0f / max(majorant - hero, 1e-30f));
    path.beta = path.beta * ratio * sigma_n;
    path.r_u = path.r_u * ray.odds(ratio * sigma_n);
    path.r_l = path.r_l * ray.odds(ratio * (delta ? sigma_n : at.sigma_maj));
    return true;
  });
  if (scattered_at >= 0.0f) return scattered_at;
  path.beta = path.beta * rest;
  path.r_u = path.r_u * ray.odds(rest);
  path.r_l = path.r_l * ray.odds(rest);
  return ray.length;
}

/// Lets a shadow ray's light pass a homogeneous medium. `from_within`: the light is a point of this medium, at the
/// ray's end, so that a path has to collide there.
inline void pass_homogeneous(const MediumRay& ray, bool from_within, PathWeights& path) {
  const MediumCoefficients c = medium_coefficients(ray.medium, ray.spectra);
  const Float4 passed = transmittance(c.sigma_t, ray.length);
  path.beta = path.beta * passed;
  if (ray.has(kMediumScatters) || from_within) path.r_u = path.r_u * ray.odds(passed);
}

/// Lets a shadow ray's light pass a heterogeneous medium: by ratio tracking, which no collision stops, or by delta
/// tracking, which the first real one stops. Returns false where nothing is left.
inline bool pass_null_collisions(const MediumRay& ray, MediumRandom& random, bool delta, TrackingCounts& counts,
                                 PathWeights& path) {
  bool open = true;
  const Float4 rest = for_each_collision(ray, random, counts, [&](const Collision& at) {
    const Float4 sigma_t = min(ray.coefficients(ray.at(at.t)).sigma_t, at.sigma_maj);
    const Float4 sigma_n = at.sigma_maj - sigma_t;
    const float majorant = at.sigma_maj[ray.hero];
    ++counts.shadow;
    if (delta) {
      open = random.next() * majorant < sigma_n[ray.hero];
      if (!open) return false;
      const Float4 ratio = at.passed * sigma_n * (1.0f / sigma_n[ray.hero]);
      path.beta = path.beta * ratio;
      path.r_u = path.r_u * ray.odds(ratio);
      path.r_l = path.r_l * ray.odds(ratio);
      return true;
    }
    const Float4 ratio = at.passed * (1.0f / majorant);
    path.beta = path.beta * ratio * sigma_n;
    path.r_u = path.r_u * ray.odds(ratio * sigma_n);
    path.r_l = path.r_l * ray.odds(ratio * at.sigma_maj);
    // Little light is worth little work: it goes on with a quarter of the probability and four times the weight.
    if (max_component(path.beta) < kRouletteThreshold * max_component(path.r_l)) {
      open = random.next() < kSurvival;
      path.beta = path.beta * (1.0f / kSurvival);
    }
    return open && max_component(path.beta) > 0.0f;
  });
  path.beta = path.beta * rest;
  if (!open || !(max_component(path.beta) > 0.0f)) return false;
  path.r_u = path.r_u * ray.odds(rest);
  path.r_l = path.r_l * ray.odds(rest);
  return true;
}

}  // namespace sheaf
