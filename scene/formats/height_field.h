// Pictures as surfaces.
#pragma once

#include "scene/description/description.h"

namespace sheaf {

/// Triangles are counted in 32 bits, corners as well.
inline constexpr std::size_t kMaxHeights = std::size_t{1} << 28;

/// Heights, row by row.
struct Heights {
  std::size_t width = 0, height = 0;  ///< two at least
  std::vector<float> z;

  float at(std::size_t x, std::size_t y) const { return z[y * width + x]; }
};

/// The mesh of heights: over [-1, 1]^2 of the xy plane, a vertex for each, the first row at y = -1; uv from (0, 0) at
/// (-1, -1). With `smooth` the vertices have normals, means of those at the corners of the cells around.
Mesh make_height_field(const Heights& heights, bool smooth);

/// The same from a picture, z the pixel's luminance times `scale`. `raw`: integers are numbers, not encoded by the sRGB
/// curve. Throws SceneError if the picture is missing, broken, has channels without a meaning, values that are not
/// finite, or fewer than 2 x 2 pixels.
Mesh read_height_field(const std::filesystem::path& file, float scale, bool smooth, bool raw);

}  // namespace sheaf
