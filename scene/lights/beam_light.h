// Beams of light along a ray.
#pragma once

#include "scene/tables/light.h"

namespace sheaf {

/// Data of a beam. LightRecord::radiance is its power, W.
template <class L> struct BeamLightData {
  Vec3<L> position;   ///< where the beam starts, world space
  Vec3<L> direction;  ///< of travel, unit length

  static constexpr auto fields(auto& s) { return std::tie(s.position, s.direction); }
};

}  // namespace sheaf
