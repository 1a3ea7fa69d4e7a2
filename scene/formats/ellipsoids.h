// Ellipsoid files in PLY format, as for 3D Gaussian splatting (Kerbl et al. 2023).
#pragma once

#include "core/math/transform.h"

#include <filesystem>
#include <vector>

namespace sheaf {

/// Reads a PLY file, ASCII or binary. Its first element holds one ellipsoid per row: center x, y, z, logarithms of the
/// semi-axes scale_0 to scale_2, and a rotation quaternion rot_0 (real part) to rot_3 (Kerbl et al. 2023). Other
/// properties are ignored. Returns the transforms of the unit sphere to the ellipsoids, with semi-axes multiplied by
/// `scale`. Throws SceneError for a missing, truncated or malformed file, for missing properties, and for values that
/// are not finite or too large.
std::vector<Transform> read_ellipsoids(const std::filesystem::path& file, float scale);

}  // namespace sheaf
