// How carefully an acceleration structure is worth being built.
#pragma once

#include "scene/tables/accel.h"

namespace sheaf {

/// How many bounding boxes of triangles a random line through the shapes' common box meets without need: expected
/// number of boxes that it crosses less that of triangles. A line crosses convex things in proportion to their surface
/// (Cauchy; see Goldsmith and Salmon, "Automatic Creation of Object Hierarchies for Ray Tracing", 1987). Large for
/// triangles that are long, large and not along the axes, whose boxes enclose many smaller ones. Shapes that are no
/// meshes don't count.
double wasted_boxes(const AccelInput& in, ShapeRange shapes);

/// Whether spatial splits (Stich, Friedrich and Dietrich, "Spatial Splits in Bounding Volume Hierarchies", 2009) are
/// worth two to three times the time to build. `shapes`: of one structure.
bool is_worth_splitting(const AccelInput& in, ShapeRange shapes);

}  // namespace sheaf
