// Reading and encoding of TIFF files (TIFF 6.0, BigTIFF) by libtiff.
#pragma once

#include "core/image/image_reader.h"
#include "core/image/image_source.h"

#include <memory>

namespace sheaf {

/// Opens the first image of a TIFF file, of integers of up to 32 bits or floats of 16, 32 and 64 bits, in strips or
/// tiles. Palettes, and CMYK without profiles, become RGB; YCbCr, CIE L*a*b* and LogLuv become RGB of 8 bits. Bilevel
/// files in which 0 is white are inverted. Alpha is as stored, multiplied or not. On failure returns null and sets
/// `problem`.
std::unique_ptr<ImageReader> open_tiff(ImageSource source, std::string& problem);

/// Encodes a TIFF file with deflate compression, labeled as sRGB. `description`: text in the header; empty: none. On
/// failure returns an empty vector and sets `problem`.
std::vector<unsigned char> encode_tiff(const IntegerPixels& pixels, const std::string& description,
                                       std::string& problem);

/// The version of libtiff.
std::string tiff_version();

}  // namespace sheaf
