// Encoding of PNG, JPEG and TIFF files, which show an image as 8-bit or 16-bit integers.
#pragma once

#include "core/image/image.h"

#include <string>
#include <vector>

namespace sheaf {

/// File formats of integers.
enum class IntegerFormat { kPng, kJpeg, kTiff };

struct IntegerEncoding {
  IntegerFormat format = IntegerFormat::kPng;
  int level = 6;            ///< PNG: compression, 0 to 9
  int quality = 95;         ///< JPEG: 1 to 100
  std::string description;  ///< text in the header; empty: none
};

/// Encodes the channels of display_channels() with the sRGB curve: 8 bits in PNG and JPEG files, 16 in TIFF files.
/// Values are clamped to [0, 1] and rounded to nearest; NaN becomes 0. PNG and TIFF files keep display_alpha() if it is
/// not 1 everywhere; colors are then assumed to be premultiplied. JPEG files show the image over black. Encodes only
/// the pixels of the image, not its frame. Throws Error (exit code 1) if the image is empty or cannot be encoded.
std::vector<unsigned char> encode_image(const Image& image, const IntegerEncoding& encoding = {});

/// Writes an image as encode_image() encodes it. Throws Error (exit code 4).
void write_encoded_image(const std::filesystem::path& path, const Image& image, const IntegerEncoding& encoding);

}  // namespace sheaf
