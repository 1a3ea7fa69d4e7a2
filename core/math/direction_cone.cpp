#include "core/math/direction_cone.h"

#include "core/simd/lanes.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sheaf {

namespace {

double dot3(const Triple& a, const Triple& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/// Whether cone `b` lies inside `a`. `cos_between` is the cosine between their axes. No trigonometry: most joins of a
/// large tree return from here.
bool contains(const DirectionCone& a, const DirectionCone& b, double cos_between) {
  if (a.theta >= std::numbers::pi) return true;
  if (a.theta < b.theta) return false;
  const double sin_between = std::sqrt(std::max(0.0, 1.0 - cos_between * cos_between));
  const double cos_reach = cos_between * b.cos_theta - sin_between * b.sin_theta;
  const double sin_reach = sin_between * b.cos_theta + cos_between * b.sin_theta;
  return sin_reach >= 0.0 && cos_reach >= a.cos_theta;
}

}  // namespace

DirectionCone::DirectionCone(const Triple& direction, double angle)
    : axis(direction), theta(angle), cos_theta(std::cos(angle)), sin_theta(std::max(0.0, std::sin(angle))) {}

DirectionCone DirectionCone::from_cosine(const Triple& axis, double cosine) {
  return {axis, std::acos(std::clamp(cosine, -1.0, 1.0))};
}

DirectionCone join(const DirectionCone& a, const DirectionCone& b) {
  const double cos_between = std::clamp(dot3(a.axis, b.axis), -1.0, 1.0);
  if (contains(a, b, cos_between)) return a;
  if (contains(b, a, cos_between)) return b;
  const double between = std::acos(cos_between);
  const double theta = 0.5 * (a.theta + b.theta + between);
  const double sin_between = std::sin(between);
  constexpr double kNearlyOpposite = 1e-6;
  if (theta >= std::numbers::pi || (cos_between < 0.0 && sin_between < kNearlyOpposite))
    return {a.axis, std::numbers::pi};
  if (sin_between < kNearlyOpposite) return {a.axis, std::max(a.theta, b.theta + between)};
  // Rotate the axis from a towards b until the cone touches both on their far sides.
  const double azimuth = theta - a.theta;
  const double of_a = std::sin(between - azimuth) / sin_between, of_b = std::sin(azimuth) / sin_between;
  Triple axis;
  for (std::size_t c = 0; c < 3; ++c) axis[c] = of_a * a.axis[c] + of_b * b.axis[c];
  const double scale = 1.0 / std::sqrt(dot3(axis, axis));
  for (double& c : axis) c *= scale;
  return {axis, theta};
}

double cone_measure(const DirectionCone& cone, double theta_e) {
  const double theta_w = std::min(cone.theta + theta_e, std::numbers::pi);
  return 2.0 * std::numbers::pi * (1.0 - cone.cos_theta) +
         0.5 * std::numbers::pi *
             (2.0 * theta_w * cone.sin_theta - std::cos(cone.theta - 2.0 * theta_w) -
              2.0 * cone.theta * cone.sin_theta + cone.cos_theta);
}

}  // namespace sheaf
