// Hair files of Mitsuba before version 2.
#pragma once

#include "core/io/error.h"
#include "scene/description/shapes.h"

namespace sheaf {

/// Options for reading a hair file.
struct HairReading {
  float radius = 0.025f;
  float angle_threshold = 1;   ///< degrees; points with smaller direction changes are dropped
  float reduction = 0;         ///< in [0, 1): fraction of hairs to drop; the others widen to compensate
  bool keep_straight = false;  ///< ignore the threshold, and keep points that equal the one before
};

/// Reads hairs as linear curves (manual of Mitsuba 0.6, "Hair intersection shape"). Text files have a point "x y z" per
/// line, and empty lines or lines that start with # between hairs. Binary files have the letters BINARY_HAIR, a 32-bit
/// number of points, and their coordinates as 32-bit floats, all little endian. An infinity precedes the first point of
/// each hair. Hairs with a single point are invisible. Throws SceneError for a missing, truncated or malformed file,
/// and for a file without hairs.
Curves read_hair_file(const std::filesystem::path& file, const HairReading& reading);

}  // namespace sheaf
