// Spot lights with linear or smooth falloff.
#pragma once

#include "scene/tables/light.h"

namespace sheaf {

/// Data of a spot light whose intensity falls off linearly in the angle. LightRecord::radiance is the intensity on its
/// axis, W / sr.
template <class L> struct LinearSpotLightData {
  Vec3<L> position;                 ///< world space
  typename L::Uint frame;           ///< into SceneView::light_frames
  typename L::Float cutoff_angle;   ///< from the axis, radians
  typename L::Float inverse_width;  ///< 1 / (cutoff angle - beam width)
  typename L::Float cot_cutoff;     ///< with a texture: 1 / tan(cutoff angle)

  static constexpr auto fields(auto& s) {
    return std::tie(s.position, s.frame, s.cutoff_angle, s.inverse_width, s.cot_cutoff);
  }
};

/// Data of a spot light whose intensity falls off as a smooth step in the cosine of the angle. LightRecord::radiance is
/// the intensity on its axis, W / sr.
template <class L> struct SmoothSpotLightData {
  Vec3<L> position;                 ///< world space
  typename L::Uint frame;           ///< into SceneView::light_frames
  typename L::Float cos_cutoff;     ///< cosine of the cutoff angle
  typename L::Float inverse_width;  ///< 1 / (cosine of the beam width - cos_cutoff)
  typename L::Float cot_cutoff;     ///< with a texture: 1 / tan(cutoff angle)

  static constexpr auto fields(auto& s) {
    return std::tie(s.position, s.frame, s.cos_cutoff, s.inverse_width, s.cot_cutoff);
  }
};

}  // namespace sheaf
