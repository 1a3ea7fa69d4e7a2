// Shapes shared by the Nori and Mitsuba dialects.
#pragma once

#include "scene/xml/properties.h"

namespace sheaf {

/// Reads the geometry of a shape. Its properties come from `p`, which the caller finishes. Returns false unless the
/// plugin is one of shared_shape_names(). `flips_obj`: texture coordinates of OBJ files start at the top by default.
/// Throws SceneError.
bool read_shared_geometry(Properties& p, bool flips_obj, ShapeDescription& shape);

/// Plugins that read_shared_geometry() supports, in alphabetical order.
const std::vector<std::string>& shared_shape_names();

}  // namespace sheaf
