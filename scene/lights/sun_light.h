// Suns: disks infinitely far away.
#pragma once

#include "scene/tables/light.h"

namespace sheaf {

/// Data of a sun.
template <class L> struct SunLightData {
  Vec3<L> to_light;                 ///< towards the centre of the disk, unit length
  typename L::Float one_minus_cos;  ///< 1 - cosine of the angular radius

  static constexpr auto fields(auto& s) { return std::tie(s.to_light, s.one_minus_cos); }
};

}  // namespace sheaf
