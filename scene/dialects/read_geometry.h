// Shapes that both dialects spell alike.
#pragma once

#include "scene/xml/properties.h"

namespace sheaf {

/// Reads the geometry of a shape, with its properties from `p`, which the caller finishes; false if the plugin is none
/// of shared_shape_names(). `flips_obj`: texture coordinates of OBJ files begin at the top unless the file says
/// otherwise. Throws SceneError.
bool read_shared_geometry(Properties& p, bool flips_obj, ShapeDescription& shape);

/// The plugins that read_shared_geometry() knows, in order of the alphabet.
const std::vector<std::string>& shared_shape_names();

}  // namespace sheaf
