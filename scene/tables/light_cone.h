// Cones of directions around the normals of lights, in double precision: what building a light tree joins.
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

/// A cone around two, the narrowest but for opposite axes (Conty Estevez and Kulla 2018, algorithm 1).
DirectionCone join(const DirectionCone& a, const DirectionCone& b);

/// The measure of the directions that lights of a cone of normals shine to, each up to `theta_e` from its normal and in
/// proportion to the cosine (Conty Estevez and Kulla 2018, equation 1).
double cone_measure(const DirectionCone& cone, double theta_e);

}  // namespace sheaf
