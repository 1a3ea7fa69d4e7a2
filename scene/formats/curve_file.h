// Mitsuba 3's files of curves.
#pragma once

#include "scene/description/description.h"

namespace sheaf {

/// Reads a text with a control point per line, "x y z radius", and one or more empty lines between curves (manual of
/// Mitsuba 3, "B-spline curve"). Throws SceneError with the line for a file that is missing or malformed, that holds no
/// curve, or one with too few points, and for radii that are negative.
Curves read_curve_file(const std::filesystem::path& file, Curves::Basis basis);

}  // namespace sheaf
