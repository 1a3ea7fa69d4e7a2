// Reading of Radiance images (Ward, "The RADIANCE Picture File Format").
#pragma once

#include "core/image/image_reader.h"
#include "core/image/image_source.h"

#include <memory>

namespace sheaf {

/// Opens a Radiance file of RGBE or XYZE colors, in any of the eight orders of its resolution string, such as
/// "-Y 512 +X 1024". Exposure, gamma and primaries of the header are ignored. On failure returns null and sets
/// `problem`.
std::unique_ptr<ImageReader> open_radiance(ImageSource source, std::string& problem);

}  // namespace sheaf
