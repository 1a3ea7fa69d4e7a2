// Cones of directions around the normals of lights, in double precision, for building light trees.
#pragma once

#include <array>

namespace sheaf {

using Vec3d = std::array<double, 3>;

/// All directions within `theta` of `axis`; theta in [0, pi].
struct DirectionCone {
  Vec3d axis{0, 0, 1};  ///< unit length
  double theta = 0;
  double cos_theta = 1, sin_theta = 0;

  DirectionCone() = default;
  DirectionCone(const Vec3d& axis, double theta);
  /// From the cosine of the half angle.
  static DirectionCone from_cosine(const Vec3d& axis, double cosine);
};

/// Bounding cone of two cones. It is the narrowest, except for opposite axes (Conty Estevez and Kulla 2018, algorithm
/// 1).
DirectionCone join(const DirectionCone& a, const DirectionCone& b);

/// Orientation measure: the directions into which lights with normals in the cone emit, each within `theta_e` of its
/// normal and weighted by the cosine (Conty Estevez and Kulla 2018, equation 1).
double cone_measure(const DirectionCone& cone, double theta_e);

}  // namespace sheaf
