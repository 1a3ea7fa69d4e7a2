// Point lights with an image of all directions.
#pragma once

#include "scene/tables/light.h"

namespace sheaf {

/// Data of a goniometric light. LightRecord::radiance is its intensity where the image is 1, W / sr.
template <class L> struct GoniometricLightData {
  Vec3<L> position;        ///< world space
  typename L::Uint frame;  ///< into SceneView::light_frames

  static constexpr auto fields(auto& s) { return std::tie(s.position, s.frame); }
};

}  // namespace sheaf
