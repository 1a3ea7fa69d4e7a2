// Spheres that emit outwards.
#pragma once

#include "scene/lights/quadric_light.h"

namespace sheaf {

/// Data of a sphere as a light. They begin with those of a quadric.
template <class L> struct SphereLightData {
  QuadricLightData<L> surface;
  Vec3<L> center;            ///< world space
  typename L::Float radius;  ///< meters

  static constexpr auto fields(auto& s) { return std::tie(s.surface, s.center, s.radius); }
};

/// See scene/lights/light.h.
struct SphereLightKind : QuadricLightKind {};

}  // namespace sheaf
