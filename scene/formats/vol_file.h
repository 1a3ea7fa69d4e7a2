// Mitsuba's grid volumes, ".vol".
#pragma once

#include "scene/description/voxels.h"

#include <filesystem>

namespace sheaf {

/// Which channels a file is expected to have.
enum class VolChannels {
  kAny,       ///< one or three
  kMatrices,  ///< six
};

/// Reads a file of version 3: "VOL", a byte for the version, then in little endian an int32 for the encoding (1: 32-bit
/// floats, 2: 16-bit floats, 3: bytes, 255 standing for 1), three for the numbers of voxels, one for the channels, six
/// floats for a box, and the values, x fastest, channels next to each other (manual of Mitsuba 0.5, "Grid-based volume
/// data source"). Voxels are the cells of the unit cube, or with `use_grid_bbox` of the file's box. Throws SceneError
/// for a file that is missing, truncated or malformed, that has other channels than expected, or values that are not
/// finite.
DenseVolume read_vol(const std::filesystem::path& file, bool use_grid_bbox, VolChannels expected = VolChannels::kAny);

/// The transform that places the unit cube where the file's box is. Throws SceneError as read_vol() does.
Transform vol_box(const std::filesystem::path& file);

}  // namespace sheaf
