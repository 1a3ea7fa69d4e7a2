// Cameras: from a position on the film to a ray.
#pragma once

#include "core/vec.h"
#include "scene/description.h"

namespace sheaf {

/// A pinhole camera, prepared for rays.
struct Camera {
  Vec3f origin{};                  ///< world space
  Vec3f corner{}, dx{}, dy{};      ///< direction of film position (x, y): corner + x dx + y dy; pixels, y downwards

  /// Normalised world-space direction through the film position (x, y) in pixels; (0, 0) is the upper left corner of
  /// the frame.
  template <class L> SHEAF_INLINE Vec3<L> direction(typename L::Float x, typename L::Float y) const {
    return normalize(broadcast<L>(corner) + broadcast<L>(dx) * x + broadcast<L>(dy) * y);
  }
};

/// Prepares a camera for a frame of width x height pixels. Throws SceneError for a field of view outside (0, 180).
Camera make_camera(const CameraDescription& description, int width, int height);

}  // namespace sheaf
