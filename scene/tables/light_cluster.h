// Bounds of some lights, in double precision: what a light tree is built of.
#pragma once

#include "scene/tables/light_cone.h"

#include <cstdint>
#include <limits>

namespace sheaf {

/// Without lights: a box inside out.
struct LightCluster {
  static constexpr double kLargest = std::numeric_limits<double>::max();

  Vec3d lower{kLargest, kLargest, kLargest}, upper{-kLargest, -kLargest, -kLargest};
  DirectionCone cone;                 ///< of normals
  double cos_theta_e = 1, power = 0;  ///< see LightBounds
  std::uint32_t count = 0;            ///< of lights
  bool two_sided = false;             ///< one of them at least

  void add(const LightCluster& other);
};

}  // namespace sheaf
