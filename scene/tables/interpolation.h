// Interpolation of textures and volume grids between their samples, and continuation beyond their borders.
#pragma once

#include <cstdint>

namespace sheaf {

/// Interpolation between the texels of an image.
enum class TextureFilter : std::uint8_t { kBilinear, kNearest };

/// Values of an image outside of the unit square.
enum class TextureWrap : std::uint8_t { kRepeat, kMirror, kClamp };

/// Interpolation between the voxels of a grid.
enum class GridFilter { kTrilinear, kNearest };

}  // namespace sheaf
