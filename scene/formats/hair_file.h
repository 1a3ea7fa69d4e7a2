// Hair of Mitsuba before version 2.
#pragma once

#include "scene/description/description.h"

namespace sheaf {

/// How much of a file of hair is read.
struct HairReading {
  float radius = 0.025f;
  float angle_threshold = 1;  ///< degrees; points at which a hair turns by less are left out
  float reduction = 0;        ///< in [0, 1): the share of hairs that is left out; the others are wider for it
};

/// Reads hairs as lines: text with a point "x y z" per line and empty lines, or those that begin with #, between hairs;
/// or the letters BINARY_HAIR, a 32-bit number of points, and their coordinates as 32-bit floats, all in little endian,
/// with an infinity before the first point of each hair (manual of Mitsuba 0.6, "Hair intersection shape"). Hairs of a
/// single point are not seen. Throws SceneError for a file that is missing, truncated or malformed, or without a hair.
Curves read_hair_file(const std::filesystem::path& file, const HairReading& reading);

}  // namespace sheaf
