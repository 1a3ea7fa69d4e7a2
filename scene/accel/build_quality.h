// Decides whether an acceleration structure is built with spatial splits.
#pragma once

#include "scene/accel/accel.h"

namespace sheaf {

/// Expected number of triangle bounding boxes that a random line through the shapes' common box crosses needlessly:
/// boxes crossed minus triangles crossed. A line crosses convex objects in proportion to their surface area (Cauchy;
/// see Goldsmith and Salmon, "Automatic Creation of Object Hierarchies for Ray Tracing", 1987). The number is large for
/// long, large triangles that are not axis-aligned, whose boxes enclose many smaller ones. Only meshes count.
double wasted_boxes(const AccelInput& in, ShapeRange shapes);

/// Whether spatial splits (Stich, Friedrich and Dietrich, "Spatial Splits in Bounding Volume Hierarchies", 2009) are
/// worth two to three times the build time. `shapes` are those of one structure.
bool is_worth_splitting(const AccelInput& in, ShapeRange shapes);

}  // namespace sheaf
