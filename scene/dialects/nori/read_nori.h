// Entry point of the Nori dialect.
#pragma once

#include "scene/xml/properties.h"

namespace sheaf {

/// Reads a Nori scene into context.description. Throws SceneError.
void read_nori(ReadContext& context);

}  // namespace sheaf
