// Parallel light from infinitely far away.
#pragma once

#include "scene/tables/light.h"

namespace sheaf {

/// Data of a directional light. LightRecord::radiance is its irradiance on a perpendicular surface, W / m^2.
template <class L> struct DirectionalLightData {
  Vec3<L> to_light;  ///< unit length

  static constexpr auto fields(auto& s) { return std::tie(s.to_light); }
};

}  // namespace sheaf
