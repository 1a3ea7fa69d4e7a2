// PNG files in memory; core/image.cpp makes them, as it makes those on the disk.
#pragma once

#include "core/image.h"

#include <vector>

namespace sheaf {

/// Compression of write_png().
inline constexpr int kPngCompression = 6;

/// What write_png() writes. `level`: of compression, 1 (fast) to 9 (small). `description`: text of the header. Throws
/// Error (exit code 1) for an empty image.
std::vector<unsigned char> encode_png(const Image& image, int level = kPngCompression,
                                      const std::string& description = {});

}  // namespace sheaf
