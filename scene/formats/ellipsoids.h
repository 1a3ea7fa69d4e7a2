// Files of ellipsoids.
#pragma once

#include "core/transform.h"

#include <filesystem>
#include <vector>

namespace sheaf {

/// Reads a PLY file, ASCII or binary, whose first element has for each ellipsoid its centre x, y, z, the logarithms of
/// its half axes scale_0 to scale_2, and a quaternion rot_0 (the real part) to rot_3 that turns it (Kerbl et al. 2023);
/// of what else there is nothing is read. Returns what takes the unit sphere to each, half axes times `scale`. Throws
/// SceneError for a file that is missing, truncated or malformed, that lacks one of these, or for values that are not
/// finite or too large.
std::vector<Transform> read_ellipsoids(const std::filesystem::path& file, float scale);

}  // namespace sheaf
