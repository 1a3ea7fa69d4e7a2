// Encoding of PNG files in memory; implemented by core/image.cpp.
#pragma once

#include "core/image.h"

#include <vector>

namespace sheaf {

/// Compression level of write_png().
inline constexpr int kPngCompression = 6;

/// Encodes an image as write_png() does. `level`: compression, 1 (fast) to 9 (small). `description`: text in the
/// header. Throws Error (exit code 1) if the image is empty or cannot be encoded.
std::vector<unsigned char> encode_png(const Image& image, int level = kPngCompression,
                                      const std::string& description = {});

}  // namespace sheaf
