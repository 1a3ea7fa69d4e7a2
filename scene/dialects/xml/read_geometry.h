// Shapes shared by the Nori and Mitsuba dialects.
#pragma once

#include "scene/xml/properties.h"

namespace sheaf {

/// Reads the geometry of a shape. Its properties come from `p`, which the caller finishes. `flips_obj`: texture
/// coordinates of OBJ files start at the top by default. Throws SceneError.
using GeometryReader = void (*)(Properties& p, bool flips_obj, ShapeDescription& shape);

/// Readers of shape plugins.
extern const NameTable<GeometryReader> kSharedShapes;

/// Readers of plugins whose points must correspond to those of the same shape at another time, where they differ from
/// those above: hairs keep all points.
extern const NameTable<GeometryReader> kShapesWithAllPoints;

}  // namespace sheaf
