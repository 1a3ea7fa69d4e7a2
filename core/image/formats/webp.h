// Reading of WebP files (RFC 9649) by libwebp.
#pragma once

#include "core/image/image_reader.h"
#include "core/image/image_source.h"

#include <memory>

namespace sheaf {

/// Opens a WebP file. Of an animation, the first frame is read, over transparent black. Colors are as stored, not
/// multiplied by alpha. On failure returns null and sets `problem`.
std::unique_ptr<ImageReader> open_webp(ImageSource source, std::string& problem);

/// The version of libwebp.
std::string webp_version();

}  // namespace sheaf
