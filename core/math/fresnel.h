// The Fresnel equations in double precision, for precomputed tables. Kernels have their own version, generic in the
// lane.
#pragma once

#include <cmath>

namespace sheaf {

/// Unpolarized reflectance of a smooth dielectric boundary, in [0, 1]. `cosine`: cosine of the angle of incidence, in
/// (0, 1]. `eta`: index of refraction behind the boundary over the index in front of it. Returns 1 beyond the critical
/// angle.
inline double fresnel_reflectance(double cosine, double eta) {
  const double cos2 = 1 - (1 - cosine * cosine) / (eta * eta);
  if (cos2 <= 0) return 1;
  const double cos_t = std::sqrt(cos2);
  const double parallel = (eta * cosine - cos_t) / (eta * cosine + cos_t);
  const double perpendicular = (cosine - eta * cos_t) / (cosine + eta * cos_t);
  return 0.5 * (parallel * parallel + perpendicular * perpendicular);
}

}  // namespace sheaf
