// Reads an image for use as a texture: selects channels, decodes values, and arranges them in tiles.
#pragma once

#include "scene/textures/bitmap.h"
#include "scene/textures/tiled_image.h"

namespace sheaf {

/// Reads the image of a bitmap: its file, or `encoded` or `made` if set. Gray (with or without alpha) and single
/// channels become one channel, and colors become three bytes, or four values the last of which is zero. Alpha is
/// dropped from colors and not multiplied in; if it is the channel and the image has none, the result is a single texel
/// of 1. 8-bit data stays unchanged, with or without `raw`. Integers of 16 bits or more become floats, decoded by the
/// sRGB curve unless is_linear(). Floats are linear, and stored as halves if all of them are exact as such; unless
/// `raw`, they are converted to Rec.709 if the file declares another color space. With a `change`, all data becomes
/// floats, decoded unless is_linear(), and transformed. Throws SceneError if the image is missing, broken or too large,
/// or has unknown channels or non-finite values; for `made`, at `where`. A FileCache keeps images of files.
std::shared_ptr<TiledImage> load_tiled_image(const BitmapDescription& bitmap, const SourceLocation& where);

}  // namespace sheaf
