// What the dialects share in reading emitters.
#pragma once

#include "scene/properties.h"

namespace sheaf {

/// `filename`, `scale` (1), `to_world` and `mis_compensation` (false).
EnvmapDescription read_envmap(Properties& p);

/// Throws SceneError at the property if the vector has no length.
void check_direction(Properties& p, const char* name, Vec3f direction);

}  // namespace sheaf
