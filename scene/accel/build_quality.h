// Decides which acceleration structures are built with spatial splits.
#pragma once

#include "scene/accel/accel.h"

namespace sheaf {

/// Expected number of triangle bounding boxes that a random line through the shapes' common box crosses needlessly:
/// boxes crossed minus triangles crossed. A line crosses convex objects in proportion to their surface area (Cauchy;
/// see Goldsmith and Salmon, "Automatic Creation of Object Hierarchies for Ray Tracing", 1987). The number is large for
/// long, large triangles that are not axis-aligned, whose boxes enclose many smaller ones. Only meshes count.
double wasted_boxes(const AccelInput& in, ShapeRange shapes);

/// Whether so few triangles need no faster build.
bool is_small_for_builds(double triangles);

/// AccelInput::splits, and the result for the whole scene.
struct SplitChoice {
  std::vector<bool> splits;
  BvhSplits result = BvhSplits::kNotNeeded;
};

/// Structures of much waste have splits if `rays`, traced in the scene, repay the build, which takes two to six times
/// as long. `rays` are shared by the instances; each of them counts for the shapes outside of groups. All structures
/// have splits if `rays` repay those of all, and in small scenes.
SplitChoice choose_splits(const AccelInput& in, double rays);

}  // namespace sheaf
