// Computes the texels of mip levels. A texel is the mean of the texels that it covers, by area and of linear values.
// Bytes are rounded up or down at random, as a function of the texel's position, so that means over several texels do
// not change.
#pragma once

#include "scene/textures/tiled_image.h"

namespace sheaf {

/// The levels of an image whose texels are read in this format, with space for their texels. The image must outlive
/// them.
std::shared_ptr<MipLevels> place_levels(const TiledImage& image, TexelFormat format);

/// Computes the coarse levels, once.
void fill_coarse_levels(MipLevels& levels);

}  // namespace sheaf
