// Height fields from images.
#pragma once

#include "core/io/error.h"
#include "scene/description/shapes.h"

namespace sheaf {

/// Maximum number of heights; triangles and their corners are counted in 32 bits.
inline constexpr std::size_t kMaxHeights = std::size_t{1} << 28;

/// Heights in row-major order.
struct Heights {
  std::size_t width = 0, height = 0;  ///< at least 2
  std::vector<float> z;

  float at(std::size_t x, std::size_t y) const { return z[y * width + x]; }
};

/// Returns the mesh of a height field over [-1, 1]^2 of the xy plane. It has one vertex per height, the first row at y
/// = -1, and uv (0, 0) at (-1, -1). With `smooth`, vertex normals average the normals at the corners of the adjacent
/// cells.
Mesh make_height_field(const Heights& heights, bool smooth);

/// Returns the height field of an image; z is the pixel's luminance times `scale`. `raw`: integers are linear, not
/// sRGB. Throws SceneError for a missing or malformed image, for unknown channels, for values that are not finite, and
/// for fewer than 2 x 2 pixels.
Mesh read_height_field(const std::filesystem::path& file, float scale, bool smooth, bool raw);

}  // namespace sheaf
