// Reading of BMP files: bitmaps of Windows and OS/2.
#pragma once

#include "core/image/image_reader.h"
#include "core/image/image_source.h"

#include <memory>

namespace sheaf {

/// Opens a BMP file of 1, 4, 8, 16, 24 or 32 bits per pixel, also run-length encoded. Palettes become colors, or gray
/// if all colors of 8 bits are gray. Of 32 bits, the fourth byte is alpha, unless masks declare other bits. On failure
/// returns null and sets `problem`.
std::unique_ptr<ImageReader> open_bmp(ImageSource source, std::string& problem);

}  // namespace sheaf
