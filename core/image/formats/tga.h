// Reading of TGA files (Truevision, "TGA FILE FORMAT SPECIFICATION", version 2.0).
#pragma once

#include "core/image/image_reader.h"
#include "core/image/image_source.h"

#include <memory>

namespace sheaf {

/// Opens a TGA file: gray, colors of 16, 24 or 32 bits, or a palette; also run-length encoded. The fourth byte of a
/// color is alpha, and colors are as stored. Gray of 16 bits has alpha if the header declares it. On failure returns
/// null and sets `problem`.
std::unique_ptr<ImageReader> open_tga(ImageSource source, std::string& problem);

}  // namespace sheaf
