// Transforms of lights that must not distort.
#pragma once

#include "core/io/error.h"
#include "core/math/transform.h"
#include "scene/tables/light.h"

#include <array>

namespace sheaf {

/// The rotation of a transform with uniform scale, from world to local space, row by row. Throws SceneError at `where`,
/// naming `what`, if the transform distorts.
std::array<double, 9> rotation_of(const Transform& to_world, const char* what, const SourceLocation& where);

/// The frame of a light at `origin` with that rotation.
LightFrameRow frame_of(const std::array<double, 9>& rotation, Vec3f origin);

}  // namespace sheaf
