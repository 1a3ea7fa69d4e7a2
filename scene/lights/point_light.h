// Isotropic point lights.
#pragma once

#include "scene/tables/light.h"

namespace sheaf {

/// Data of a point light. LightRecord::radiance is its intensity, W / sr.
template <class L> struct PointLightData {
  Vec3<L> position;  ///< world space

  static constexpr auto fields(auto& s) { return std::tie(s.position); }
};

}  // namespace sheaf
