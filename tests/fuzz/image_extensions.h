// The image formats that are tried.
#pragma once

#include <string_view>

namespace sheaf::fuzz {

inline constexpr std::string_view kImageExtensions[] = {"png", "jpg", "tif", "hdr", "bmp",
                                                        "tga", "pgm", "ppm", "pfm", "webp"};

}  // namespace sheaf::fuzz
