// OpenEXR files as pictures: the colours of the display window, whatever else a file holds.
#pragma once

#include "core/image.h"

namespace sheaf {

/// The channels that find_color_channels() finds, named R, G and B, or Y, and A; in linear Rec.709 unless `raw`:
/// colours of the primaries that the part's attribute `chromaticities` gives, and CIE XYZ, are converted without
/// chromatic adaptation, as Mitsuba does; pixels with infinities or NaN are left as they are. The picture is the
/// display window: 0 where the data window does not reach. Throws SceneError as read_exr() does, for chromaticities
/// that no colour space has, and where the two windows have no pixel in common.
Picture read_exr_picture(const std::filesystem::path& path, bool raw);

}  // namespace sheaf
