// Pictures as surfaces.
#pragma once

#include "scene/description/description.h"

namespace sheaf {

/// The mesh of a height field: over [-1, 1]^2 of the xy plane, a vertex for each pixel, the first row of the picture at
/// y = -1, z the pixel's luminance times `scale`; uv from (0, 0) at (-1, -1). With `smooth` the vertices have normals,
/// means of those at the corners of the cells around. `raw`: integers are numbers, not encoded by the sRGB curve.
/// Throws SceneError if the picture is missing, broken, has channels without a meaning, values that are not finite, or
/// fewer than 2 x 2 pixels.
Mesh read_height_field(const std::filesystem::path& file, float scale, bool smooth, bool raw);

}  // namespace sheaf
