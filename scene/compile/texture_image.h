// Reading one picture for use as a texture: which channels count, what their numbers mean, and their order in memory.
#pragma once

#include "scene/tables/texture.h"

namespace sheaf {

/// A picture cut into tiles.
struct TiledImage {
  std::uint32_t width = 0, height = 0;  ///< texels
  std::uint32_t tiles_per_row = 0;
  TexelFormat format = TexelFormat::kByte1;  ///< of bytes kByte1 or kByte4, whatever they mean
  std::vector<TexelTile> tiles;
};

/// Reads a picture: grey (with or without alpha) becomes one channel, colours four, of which the last is zero; alpha is
/// dropped and nothing is multiplied by it. 8-bit data stays as it is, so that `raw` makes no difference; integers of
/// 16 bits and more become floats, which unless `raw` are decoded by the sRGB curve. Floats mean linear values, which
/// unless `raw` are converted to Rec.709 where the file says that they are colours of another space. With a
/// `change` all data become floats, decoded unless `raw`, and changed. Throws SceneError if the picture is missing,
/// broken or too large, has channels without a meaning, or values that are not finite.
TiledImage load_tiled_image(const std::filesystem::path& file, bool raw,
                            const BitmapDescription::ColorTransform& change = {});

/// The same of a picture in memory, of linear values.
TiledImage tile_image(const Image& made, const BitmapDescription::ColorTransform& change, const SourceLocation& where);

}  // namespace sheaf
