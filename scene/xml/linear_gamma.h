// The gamma of image files in Mitsuba 0.6.
#pragma once

#include "scene/xml/properties.h"

namespace sheaf {

/// Whether `gamma` of Mitsuba 0.6 treats the integers of an image file as linear values (1), not as sRGB (-1, 0 and,
/// with a note, 2.2). Throws SceneError for other values.
bool read_linear_gamma(Properties& p);

}  // namespace sheaf
