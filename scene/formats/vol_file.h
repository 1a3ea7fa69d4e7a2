// Mitsuba's ".vol" grid volumes.
#pragma once

#include "scene/description/voxels.h"

#include <filesystem>

namespace sheaf {

/// Expected number of channels.
enum class VolChannels {
  kAny,       ///< one or three
  kMatrices,  ///< six
};

/// Reads a file of version 3 (manual of Mitsuba 0.5, "Grid-based volume data source"), all numbers little endian:
///   - "VOL" and a byte for the version,
///   - int32 encoding (1: 32-bit floats, 2: 16-bit floats, 3: bytes, where 255 is 1),
///   - three int32 for the resolution, one for the number of channels,
///   - six floats for a bounding box,
///   - the values, x fastest, channels interleaved.
/// Voxels are cells of the unit cube, or of the file's bounding box if `use_grid_bbox`. Throws SceneError for a
/// missing, truncated or malformed file, for an unexpected number of channels, and for values that are not finite.
DenseVolume read_vol(const std::filesystem::path& file, bool use_grid_bbox, VolChannels expected = VolChannels::kAny);

/// Returns the transform of the unit cube to the file's bounding box. Throws SceneError as read_vol() does.
Transform vol_box(const std::filesystem::path& file);

}  // namespace sheaf
