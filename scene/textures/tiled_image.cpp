#include "scene/textures/tiled_image.h"

namespace sheaf {

std::size_t TextureTables::texel_bytes() const {
  std::size_t tiles = 0;
  for (std::size_t i = 0; i < images.size(); ++i) {
    if (images[i].mip_levels != nullptr) continue;  // the same image again
    tiles += tiled_images[i]->tiles.size();
    for (const auto& levels : {tiled_images[i]->mip_levels, tiled_images[i]->srgb_mip_levels})
      if (levels) tiles += levels->tiles.size();
  }
  return tiles * sizeof(TexelLine);
}

}  // namespace sheaf
