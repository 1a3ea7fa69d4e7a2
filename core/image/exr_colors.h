// Colors of OpenEXR files: the color channels of the display window, without all other layers and parts.
#pragma once

#include "core/image/image.h"

namespace sheaf {

/// Reads the channels that find_color_channels() selects, named R, G and B, or Y, and A. Unless `raw`, converts R, G
/// and B to linear Rec.709: from CIE XYZ, or from the primaries in the attribute `chromaticities` of the part. Like
/// Mitsuba, it applies no chromatic adaptation. Pixels with infinities or NaN stay unchanged. The image covers the
/// display window and is 0 outside the data window. Throws SceneError like read_exr(), for chromaticities that define
/// no color space, and if the two windows do not overlap.
StoredImage read_exr_colors(const std::filesystem::path& path, bool raw);

}  // namespace sheaf
