// Cones of directions in double precision, for building light trees.
#pragma once

#include "core/math/vec3d.h"

namespace sheaf {

/// All directions within `theta` of `axis`; theta in [0, pi].
struct DirectionCone {
  Triple axis{0, 0, 1};  ///< unit length
  double theta = 0;
  double cos_theta = 1, sin_theta = 0;

  DirectionCone() = default;
  DirectionCone(const Triple& axis, double theta);
  /// From the cosine of the half angle.
  static DirectionCone from_cosine(const Triple& axis, double cosine);
};

/// Bounding cone of two cones. It is the narrowest, except for opposite axes (Conty Estevez and Kulla 2018, algorithm
/// 1).
DirectionCone join(const DirectionCone& a, const DirectionCone& b);

/// Orientation measure: the directions into which lights with normals in the cone emit, each within `theta_e` of its
/// normal and weighted by the cosine (Conty Estevez and Kulla 2018, equation 1).
double cone_measure(const DirectionCone& cone, double theta_e);

}  // namespace sheaf
