// Reads an image for use as a texture: selects channels, decodes values, and arranges them in tiles.
#pragma once

#include "scene/tables/texture.h"
#include "scene/textures/bitmap.h"

#include <filesystem>

namespace sheaf {

/// An image divided into tiles.
struct TiledImage {
  std::uint32_t width = 0, height = 0;  ///< texels
  std::uint32_t tiles_per_row = 0;
  TexelFormat format = TexelFormat::kByte1;  ///< bytes are kByte1 or kByte4, decoded or not
  std::vector<TexelTile> tiles;
};

/// Reads an image. Grey (with or without alpha) becomes one channel, and colours become four, the last of which is
/// zero. Alpha is dropped and not multiplied in. 8-bit data stays unchanged, with or without `raw`. Integers of 16 bits
/// or more become floats, decoded by the sRGB curve unless `raw`. Floats are linear; unless `raw`, they are converted
/// to Rec.709 if the file declares another colour space. With a `change`, all data becomes floats, decoded unless
/// `raw`, and transformed. Throws SceneError if the image is missing, broken or too large, or has unknown channels or
/// non-finite values. A FileCache keeps the result.
TiledImage load_tiled_image(const std::filesystem::path& file, bool raw,
                            const BitmapDescription::ColorTransform& change = {});

/// The same for an image in memory with linear values.
TiledImage tile_image(const Image& made, const BitmapDescription::ColorTransform& change, const SourceLocation& where);

}  // namespace sheaf
