// Square environment maps of equal areas, as pbrt-v4 has them.
#pragma once

#include "scene/compile/compile_envmap.h"

namespace sheaf {

/// The map by longitude and latitude, as make_envmap() wants it, of one by equal_area_octahedral(), whose texels hold
/// one value each, row by row from y = 0. Means over all directions are kept. Throws SceneError, naming `file`, if the
/// picture is not square.
EnvmapPicture lat_long_of_octahedral(const EnvmapPicture& square, const std::filesystem::path& file);

}  // namespace sheaf
