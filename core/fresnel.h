// Fresnel's equations in double precision, for tables that are made once; kernels have their own for lanes.
#pragma once

#include <cmath>

namespace sheaf {

/// Unpolarized reflectance of a smooth dielectric boundary, in [0, 1]. `cosine`: of the angle of incidence, in (0, 1];
/// `eta`: index behind the boundary over the index in front. 1 beyond the critical angle.
inline double fresnel_reflectance(double cosine, double eta) {
  const double cos2 = 1 - (1 - cosine * cosine) / (eta * eta);
  if (cos2 <= 0) return 1;
  const double cos_t = std::sqrt(cos2);
  const double parallel = (eta * cosine - cos_t) / (eta * cosine + cos_t);
  const double perpendicular = (cosine - eta * cos_t) / (cosine + eta * cos_t);
  return 0.5 * (parallel * parallel + perpendicular * perpendicular);
}

}  // namespace sheaf
