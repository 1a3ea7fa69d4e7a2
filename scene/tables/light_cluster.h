// Bounds of a set of lights in double precision, used to build light trees.
#pragma once

#include "core/math/direction_cone.h"

#include <cstdint>
#include <limits>

namespace sheaf {

/// Default: no lights, with an empty box.
struct LightCluster {
  static constexpr double kLargest = std::numeric_limits<double>::max();

  Triple lower{kLargest, kLargest, kLargest}, upper{-kLargest, -kLargest, -kLargest};
  DirectionCone cone;                 ///< cone of normals
  double cos_theta_e = 1, power = 0;  ///< see LightBounds
  std::uint32_t count = 0;            ///< number of lights
  bool two_sided = false;             ///< at least one light is two-sided

  void add(const LightCluster& other);
};

}  // namespace sheaf
