// Tracking: samples the distance at which a path scatters in a medium, and estimates transmittance.
//
// Distances are sampled by the extinction of one of four lanes, the hero. r_u and r_l keep the pdfs with which the
// other lanes would have sampled the same path, and contributions are divided by the mean of these pdfs. This is the
// spectral MIS of Miller, Georgiev and Jarosz 2019, "A Null-Scattering Path Integral Formulation of Light Transport",
// sections 5.1 and 6, in the rescaled form of Pharr et al. 2023, section 14.2.2. If MediumRay::weighted is false, the
// hero is the lane of the largest extinction, and all lanes use its pdfs. Homogeneous media are sampled in closed form
// and have exact transmittance: light sampling passes through them with probability 1.
#pragma once

#include "kernels/media/density_tracking.h"
#include "kernels/media/tracking_counts.h"
#include "scene/tables/medium_lookup.h"

namespace sheaf {

/// The largest component of r_u, over which paths are rescaled.
inline constexpr float kLargestPdf = 1e6f;

/// Throughput and RescaledPdfs of a path, in registers.
struct PathWeights {
  Float4 beta, r_u, r_l;

  /// Divides by a common factor, which cancels in the estimate, before lanes of very different magnitude overflow.
  void rescale() {
    const float largest = max_component(r_u);
    if (!(largest > kLargestPdf)) return;
    const float factor = 1.0f / largest;
    beta = beta * factor;
    r_u = r_u * factor;
    r_l = r_l * factor;
  }
};

/// Longer than any scene, but short enough that products with coefficients stay finite.
inline constexpr float kLongestStretch = 1e18f;

/// A segment of a ray within one medium. Points are relative to the grids of the medium: if these move, to where the
/// tables have them (kernels/media/moving_medium.h).
struct MediumRay {
  const SceneView& scene;
  const MediumRow& medium;
  MediumSpectra spectra;    ///< for this ray's direction, if extinction depends on it
  Spectrum4 lambda;         ///< the path's wavelengths
  Vec3f origin, direction;  ///< unit length, unless the medium is stretched
  float length;             ///< meters of world space, at most kLongestStretch
  int hero;                 ///< lane by which distances are sampled
  bool weighted;            ///< the other lanes have their own pdfs

  Vec3f at(float t) const { return origin + direction * t; }
  bool has(std::uint32_t flag) const { return (medium.flags & flag) != 0; }
  MediumCoefficients coefficients(Vec3f p) const {
    MediumCoefficients c = medium_coefficients(scene, medium, spectra, p, lambda);
    if (!has(kMediumFlakes)) [[likely]]
      return c;
    const float projected_area = flake_projected_area(scene, medium, p, direction);
    return {c.sigma_a * projected_area, c.sigma_s * projected_area, c.sigma_t * projected_area};
  }
  Float4 emission(Vec3f p) const { return medium_emission(scene, medium, spectra, p, lambda); }
  /// Factor on the pdfs of the lanes, given the factor `ratio` relative to the hero's pdf.
  Float4 pdf_ratio(Float4 ratio) const { return weighted ? ratio : Float4(ratio[hero]); }
};

/// Transmittance over a distance in meters.
SHEAF_INLINE Float4 transmittance(Float4 sigma_t, float distance) { return exp(sigma_t * -distance); }

/// Samples a distance for the extinction `sigma` > 0 by u in [0, 1).
SHEAF_INLINE float exponential_distance(float sigma, float u) { return -std::log1p(-u) / sigma; }

/// Samples the scattering distance in a homogeneous medium by u in [0, 1). Returns the distance, or the ray's length if
/// the path passes.
inline float track_homogeneous(const MediumRay& ray, float u, PathWeights& path) {
  const MediumCoefficients c = medium_coefficients(ray.medium, ray.spectra);
  const Float4 sigma_t = c.sigma_t;
  if (!ray.has(kMediumScatters)) {
    path.beta = path.beta * transmittance(sigma_t, ray.length);
    return ray.length;
  }
  const float sigma = sigma_t[ray.hero];
  const float t = sigma > 0.0f ? exponential_distance(sigma, u) : kInfinity;
  // Scatter in the medium.
  if (t < ray.length) {
    const Float4 passed = transmittance(sigma_t, t);
    const Float4 ratio = passed * (1.0f / (passed[ray.hero] * sigma));
    path.beta = path.beta * ratio * c.sigma_s;
    path.r_u = path.r_u * ray.pdf_ratio(ratio * sigma_t);
    return t;
  }
  // Pass through the medium
  const Float4 passed = transmittance(sigma_t, ray.length);
  const float p = passed[ray.hero];
  const Float4 ratio = passed * (1.0f / p);
  path.beta = path.beta * ratio;
  path.r_u = path.r_u * ray.pdf_ratio(ratio);
  path.r_l = path.r_l * (1.0f / p);
  return ray.length;
}

/// Majorant of all lanes, given the grid's bound on the factor that scales the medium's spectra.
SHEAF_INLINE Float4 majorant_spectrum(const MediumRay& ray, float bound) {
  const Float4 density_scale =
      ray.has(kMediumAbsorptionScattering) ? ray.spectra.first + ray.spectra.second : ray.spectra.first;
  return density_scale * bound;
}

/// The majorant that a traversal of the grid finds at a point.
inline float majorant_at(const MajorantGridRow& row, Vec3f p) {
  if (row.bounds == nullptr || !is_in_box(row, p)) return row.outside;
  bool hits;
  const LeafWalk<Scalar> walk = start_leaf_walk<Scalar>(row, p, {1, 1, 1}, 0.0f, kInfinity, hits);
  return find_leaf<Scalar>(row, walk).majorant;
}

/// Pdf per meter and lane of a collision at `p` as MediumEmission counts it, without the transmittance up to `p`.
inline Float4 collision_density(const MediumRay& ray, Vec3f p) {
  if (ray.has(kMediumHomogeneous)) return ray.pdf_ratio(medium_coefficients(ray.medium, ray.spectra).sigma_t);
  return ray.pdf_ratio(majorant_spectrum(ray, majorant_at(ray.scene.media.majorants[ray.medium.majorants], p)));
}

/// A tentative collision with a medium that null particles fill up to its majorant.
struct Collision {
  float t;           ///< meters from the ray's origin
  Float4 sigma_maj;  ///< majorant there, 1/m; positive in the hero lane
  Float4 passed;     ///< majorant transmittance since the last collision, over that of the hero
};

/// Calls collide(Collision) at each tentative collision, nearest first, until it returns false. Returns the majorant
/// transmittance from the last collision to the end of the ray, over that of the hero; 0 after kMaxCollisions.
template <class Collide>
SHEAF_INLINE Float4 for_each_collision(const MediumRay& ray, MediumRandom& random, TrackingCounts& counts,
                                       Collide&& collide) {
  const bool gray = ray.has(kMediumGray);
  std::uint32_t collisions_left = kMaxCollisions;
  // Remaining optical depth of the hero lane until the next collision.
  float depth = detail::exponential<Scalar>(random.next());
  MajorantWalk walk(ray.scene.media.majorants[ray.medium.majorants], ray.origin, ray.direction, 0.0f, ray.length);
  MajorantSegment segment;
  Float4 passed(1.0f);
  while (walk.next(segment)) {
    const Float4 sigma_maj = majorant_spectrum(ray, segment.bound);
    const float sigma = sigma_maj[ray.hero];
    for (float t = segment.t0;;) {
      // Step to the next collision or to the end of the segment
      const float left = segment.t1 - t;
      const bool collides = sigma * left > depth;
      const float step = collides ? depth / sigma : left;
      if (!gray) passed = passed * exp((Float4(sigma) - sigma_maj) * step);
      if (!collides) {
        depth -= sigma * left;
        break;
      }
      t += step;
      // Report the collision and sample the depth of the next one
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

/// Samples the scattering distance in a heterogeneous medium. Absorption is a factor, not an event. `emit` is called
/// first at each tentative collision, with the path before the collision. Returns the distance, or the ray's length if
/// the path passes.
template <class Emit>
inline float track_null_collisions(const MediumRay& ray, MediumRandom& random, bool delta, TrackingCounts& counts,
                                   PathWeights& path, Emit&& emit) {
  float scattered_at = -1.0f;
  const Float4 rest = for_each_collision(ray, random, counts, [&](const Collision& at) {
    const Vec3f p = ray.at(at.t);
    emit(at, p, path);
    const MediumCoefficients c = ray.coefficients(p);
    // The majorant holds up to rounding only: clamp to it.
    const Float4 sigma_t = min(c.sigma_t, at.sigma_maj);
    const float hero = sigma_t[ray.hero], majorant = at.sigma_maj[ray.hero];
    // Real collision: scatter.
    if (random.next() * majorant < hero) {
      ++counts.real;
      const Float4 ratio = at.passed * (1.0f / hero);
      path.beta = path.beta * ratio * c.sigma_s;
      path.r_u = path.r_u * ray.pdf_ratio(ratio * sigma_t);
      scattered_at = at.t;
      return false;
    }
    // Null collision: continue.
    ++counts.null;
    const Float4 sigma_n = at.sigma_maj - sigma_t;
    const Float4 ratio = at.passed * (1.0f / max(majorant - hero, 1e-30f));
    path.beta = path.beta * ratio * sigma_n;
    path.r_u = path.r_u * ray.pdf_ratio(ratio * sigma_n);
    path.r_l = path.r_l * ray.pdf_ratio(ratio * (delta ? sigma_n : at.sigma_maj));
    return true;
  });
  if (scattered_at >= 0.0f) return scattered_at;
  path.beta = path.beta * rest;
  path.r_u = path.r_u * ray.pdf_ratio(rest);
  path.r_l = path.r_l * ray.pdf_ratio(rest);
  return ray.length;
}

/// Applies the transmittance of a homogeneous medium along a shadow ray. `from_within`: the light is a point of this
/// medium at the end of the ray, so a path has to collide there.
inline void pass_homogeneous(const MediumRay& ray, bool from_within, PathWeights& path) {
  const MediumCoefficients c = medium_coefficients(ray.medium, ray.spectra);
  const Float4 passed = transmittance(c.sigma_t, ray.length);
  path.beta = path.beta * passed;
  if (ray.has(kMediumScatters) || from_within) path.r_u = path.r_u * ray.pdf_ratio(passed);
}

/// Estimates the transmittance of a heterogeneous medium along a shadow ray: by ratio tracking, or with `delta` by
/// delta tracking, where the first real collision ends the ray. Returns false if no light is left.
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
      path.r_u = path.r_u * ray.pdf_ratio(ratio);
      path.r_l = path.r_l * ray.pdf_ratio(ratio);
      return true;
    }
    const Float4 ratio = at.passed * (1.0f / majorant);
    path.beta = path.beta * ratio * sigma_n;
    path.r_u = path.r_u * ray.pdf_ratio(ratio * sigma_n);
    path.r_l = path.r_l * ray.pdf_ratio(ratio * at.sigma_maj);
    // Russian roulette: small contributions survive with probability kSurvival.
    if (max_component(path.beta) < kRouletteThreshold * max_component(path.r_l)) {
      open = random.next() < kSurvival;
      path.beta = path.beta * (1.0f / kSurvival);
    }
    return open && max_component(path.beta) > 0.0f;
  });
  path.beta = path.beta * rest;
  if (!open || !(max_component(path.beta) > 0.0f)) return false;
  path.r_u = path.r_u * ray.pdf_ratio(rest);
  path.r_l = path.r_l * ray.pdf_ratio(rest);
  return true;
}

}  // namespace sheaf
