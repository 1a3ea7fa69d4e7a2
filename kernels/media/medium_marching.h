// Ray marching: steps of equal length, each with the coefficients at one random point in the step. The random offset is
// the same for all steps of a ray. Biased: the optical depth is noisy, so the mean of its exponential overestimates the
// transmittance. The error decreases at least in proportion to the step length.
#pragma once

#include "kernels/media/medium_tracking.h"

namespace sheaf {

/// Calls step(begin, length, coefficients, point) for each step along the ray until it returns false.
template <class Step> SHEAF_INLINE void for_each_step(const MediumRay& ray, float jitter, Step&& step) {
  // Maximum number of steps, for rays of infinite length.
  constexpr float kMaxSteps = 1e5f;
  const float size = max(ray.medium.step_size, 1e-7f);
  const float end = min(ray.length, size * kMaxSteps);
  for (float i = 0.0f; i * size < end; i += 1.0f) {
    const float begin = i * size, length = min(size, end - begin);
    const Vec3f p = ray.at(begin + jitter * length);
    if (!step(begin, length, ray.coefficients(p), p)) return;
  }
}

/// As track_null_collisions(), by ray marching, with u in [0, 1) for the distance. For emission it calls
/// emission.add_step(path, transmittance up to the step, coefficients, point, length) at each step.
template <class MediumEmission>
inline float march(const MediumRay& ray, float u, MediumRandom& random, TrackingCounts& counts, PathWeights& path,
                   MediumEmission& emission) {
  // Sample the optical depth at which the path scatters
  const float target = exponential_distance(1.0f, u);
  Float4 depth;
  float found = -1.0f;
  for_each_step(ray, random.next(), [&](float begin, float length, const MediumCoefficients& c, Vec3f p) {
    const Float4 sigma_t = c.sigma_t;
    const float before = depth[ray.hero], after = before + sigma_t[ray.hero] * length;
    if (ray.has(kMediumEmits)) emission.add_step(path, exp(Float4() - depth), c, p, length);
    ++counts.null;
    if (!(after > target) || !ray.has(kMediumScatters)) {
      depth = depth + sigma_t * length;
      return true;
    }
    // Scatter within this step.
    const float step = (target - before) / sigma_t[ray.hero];
    depth = depth + sigma_t * step;
    const Float4 passed = exp(Float4() - depth);
    const Float4 ratio = passed * (1.0f / (passed[ray.hero] * sigma_t[ray.hero]));
    path.beta = path.beta * ratio * c.sigma_s;
    path.r_u = path.r_u * ray.pdf_ratio(ratio * sigma_t);
    found = begin + step;
    return false;
  });
  if (found >= 0.0f) {
    ++counts.real;
    --counts.null;
    return found;
  }
  // Pass through the medium
  const Float4 passed = exp(Float4() - depth);
  if (!ray.has(kMediumScatters)) {
    path.beta = path.beta * passed;
    return ray.length;
  }
  const float p = max(passed[ray.hero], 1e-30f);
  path.beta = path.beta * passed * (1.0f / p);
  path.r_u = path.r_u * ray.pdf_ratio(passed * (1.0f / p));
  path.r_l = path.r_l * (1.0f / p);
  return ray.length;
}

/// Applies the transmittance along a shadow ray.
inline void pass_by_marching(const MediumRay& ray, MediumRandom& random, TrackingCounts& counts, PathWeights& path) {
  Float4 depth;
  for_each_step(ray, random.next(), [&](float, float length, const MediumCoefficients& c, Vec3f) {
    depth = depth + c.sigma_t * length;
    ++counts.shadow;
    return true;
  });
  const Float4 passed = exp(Float4() - depth);
  path.beta = path.beta * passed;
  if (ray.has(kMediumScatters)) path.r_u = path.r_u * ray.pdf_ratio(passed);
}

}  // namespace sheaf
