// Appending of materials to the description.
#pragma once

#include "scene/xml/properties.h"

namespace sheaf {

/// Appends a material, returns its index.
MaterialId add_material(ReadContext& context, MaterialDescription material);

}  // namespace sheaf
