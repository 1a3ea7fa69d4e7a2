// Decides how acceleration structures are built.
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

/// AccelInput::builds, and what became of spatial splits in the whole scene.
struct BuildChoice {
  std::vector<BvhBuild> builds;
  BvhSplits splits = BvhSplits::kNotNeeded;
};

/// Structures of much waste have spatial splits if `rays`, traced in the scene, repay the build, which takes two to six
/// times as long. `rays` are shared by the instances; each of them counts for the shapes outside of groups. All
/// structures of much waste have splits if `rays` repay those of all, and in small scenes. Structures of large meshes
/// that meet very few rays are built along a Morton curve.
BuildChoice choose_builds(const AccelInput& in, double rays);

}  // namespace sheaf
