// Transforms of lights that must not stretch.
#pragma once

#include "core/error.h"
#include "core/transform.h"

#include <array>

namespace sheaf {

/// The rotation of a transform that scales all lengths alike, world to local, row by row. Throws SceneError at `where`,
/// naming `what`, if it stretches.
std::array<double, 9> rotation_of(const Transform& to_world, const char* what, const SourceLocation& where);

}  // namespace sheaf
