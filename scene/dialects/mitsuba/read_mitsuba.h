// Entry point of the Mitsuba dialect.
#pragma once

#include "scene/xml/properties.h"

namespace sheaf {

/// Reads a Mitsuba scene (0.6, 2, 3) into context.description. Throws SceneError.
void read_mitsuba(ReadContext& context);

}  // namespace sheaf
