// Square environment maps of equal areas, as pbrt-v4 has them.
#pragma once

#include "scene/compile/compile_envmap.h"

namespace sheaf {

/// The place in the unit square of a unit direction: the map of the octahedron that keeps areas (Clarberg, "Fast
/// Equal-Area Mapping of the (Hemi)Sphere using SIMD", JGT 2008). +z is the middle, -z all four corners, +x lies at
/// (1, 1/2) and +y at (1/2, 1).
Vec2f octahedral_of_direction(Vec3f direction);

/// The map by longitude and latitude, as make_envmap() wants it, of one by octahedral_of_direction(), whose texels hold
/// one value each, row by row from y = 0. Means over all directions are kept. Throws SceneError, naming `file`, if the
/// picture is not square.
EnvmapPicture lat_long_of_octahedral(const EnvmapPicture& square, const std::filesystem::path& file);

}  // namespace sheaf
