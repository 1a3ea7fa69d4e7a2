// Reading and encoding of JPEG files (ITU-T T.81, T.871) by libjpeg-turbo.
#pragma once

#include "core/image/image_reader.h"
#include "core/image/image_source.h"

#include <memory>

namespace sheaf {

/// Opens a JPEG file. YCbCr becomes RGB. CMYK and YCCK become RGB as the product of each ink with black, both inverted,
/// as files with Adobe's marker hold them; profiles are ignored. On failure returns null and sets `problem`.
std::unique_ptr<ImageReader> open_jpeg(ImageSource source, std::string& problem);

/// Encodes 8-bit gray or RGB pixels as a baseline JPEG file, labeled as sRGB, without subsampling. `quality`: 1 to 100.
/// `description`: a comment; empty: none. On failure returns an empty vector and sets `problem`.
std::vector<unsigned char> encode_jpeg(const IntegerPixels& pixels, int quality, const std::string& description,
                                       std::string& problem);

/// The version of libjpeg-turbo.
std::string jpeg_version();

}  // namespace sheaf
