// Square equal-area environment maps (Clarberg 2008), as in pbrt-v4.
#pragma once

#include "scene/compile/compile_envmap.h"

namespace sheaf {

/// Converts an equal-area octahedral map to the latitude-longitude map that make_envmap() takes. The layout is that of
/// equal_area_octahedral(), with one value per texel, row by row from y = 0. Means over all directions are preserved.
/// Throws SceneError, naming `file`, if the image is not square.
EnvmapImage lat_long_of_octahedral(const EnvmapImage& square, const std::filesystem::path& file);

}  // namespace sheaf
