// Fields of view of cameras and projectors.
#pragma once

#include "core/io/error.h"
#include "scene/description/camera.h"

namespace sheaf {

/// Tangent of half the horizontal field of view of an image of the given size, for `fov` degrees along `axis`. Throws
/// SceneError at `where` for angles outside (0, 180).
double half_width_of(float fov, CameraDescription::FovAxis axis, double width, double height,
                     const SourceLocation& where);

}  // namespace sheaf
