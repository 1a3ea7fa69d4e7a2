// Images as textures read them: tiles of texels, and mip levels (Williams 1983, "Pyramidal Parametrics").
#pragma once

#include "core/soa/large_table.h"
#include "scene/tables/texture.h"

#include <atomic>
#include <memory>
#include <mutex>
#include <vector>

namespace sheaf {

struct TiledImage;

/// The mip levels of an image. The coarse levels are computed before lookups. The fine ones, which take nearly all of
/// the memory, are computed when a lookup first needs one: many images are only seen larger, or only from afar.
struct MipLevels {
  const TiledImage* image = nullptr;
  TexelFormat format = TexelFormat::kByte1;  ///< in which the image is read
  std::vector<MipLevel> levels;              ///< levels 1, 2 and so on
  UninitializedLargeTable<TexelLine> tiles;  ///< levels one after the other, and one line of padding
  std::once_flag coarse_once, fine_once;
  std::atomic<bool> has_fine = false;
};

/// Computes the fine levels, once. Callable from all threads.
void fill_fine_levels(MipLevels& levels);

/// An image divided into tiles. Scenes that are loaded one after the other share it through a FileCache.
struct TiledImage {
  std::uint32_t width = 0, height = 0;  ///< texels
  std::uint32_t tiles_per_row = 0;
  TexelFormat format = TexelFormat::kByte1;    ///< bytes are kByte1 or kByte3, decoded or not
  UninitializedLargeTable<TexelLine> tiles;    ///< followed by one line of padding
  std::shared_ptr<MipLevels> mip_levels;       ///< null until they are needed
  std::shared_ptr<MipLevels> srgb_mip_levels;  ///< of sRGB-encoded bytes
};

}  // namespace sheaf
