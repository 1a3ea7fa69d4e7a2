// Projectors.
#pragma once

#include "scene/tables/light.h"

namespace sheaf {

/// Data of a projector. LightRecord::radiance is the intensity (W / sr) on its axis where the image is 1.
template <class L> struct ProjectorLightData {
  Vec3<L> position;        ///< world space
  typename L::Uint frame;  ///< into SceneView::light_frames
  Vec2<L> image_scale;     ///< reciprocals of the image's width and height at z = 1

  static constexpr auto fields(auto& s) { return std::tie(s.position, s.frame, s.image_scale); }
};

}  // namespace sheaf
