// Reading and encoding of PNG files (ISO/IEC 15948) by libpng.
#pragma once

#include "core/image/image_reader.h"
#include "core/image/image_source.h"

#include <memory>

namespace sheaf {

/// Opens a PNG file. Palettes become colors, transparency becomes alpha, and values of 1, 2 and 4 bits become bytes;
/// colors are as stored, whatever gamma or profile the file names. On failure returns null and sets `problem`.
std::unique_ptr<ImageReader> open_png(ImageSource source, std::string& problem);

/// Encodes a PNG file, labeled as sRGB. `level`: compression, 0 to 9. `description`: text in the header; empty: none.
/// On failure returns an empty vector and sets `problem`.
std::vector<unsigned char> encode_png(const IntegerPixels& pixels, int level, const std::string& description,
                                      std::string& problem);

/// The version of libpng.
std::string png_version();

}  // namespace sheaf
