// Curve files of Mitsuba 3.
#pragma once

#include "core/io/error.h"
#include "scene/description/shapes.h"

namespace sheaf {

/// Reads a text file with one control point per line, "x y z radius", and one or more empty lines between curves
/// (manual of Mitsuba 3, "B-spline curve"). Throws SceneError with the line for a missing or malformed file, for a file
/// without curves, for curves with too few points, and for negative radii.
Curves read_curve_file(const std::filesystem::path& file, Curves::Basis basis);

}  // namespace sheaf
