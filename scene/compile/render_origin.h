// The space in which a scene is rendered. Single precision resolves 2^-24 of the distance from the origin. A scene far
// from the origin of its file is therefore rendered relative to a point near the camera, to which its transforms lead
// in double precision (Pharr et al. 2023, "Physically Based Rendering", 4th ed., section 5.1.1: camera-world space).
#pragma once

#include "scene/description.h"

#include <span>

namespace sheaf {

/// A point near the camera, relative to which a scene should be rendered, in world space; zero if the scene is not far
/// from the origin. Small motions of the camera rarely change it. `points`: one or more on each shape.
Vec3d render_origin(Vec3d camera, std::span<const Vec3d> points);

/// The same by the camera and a point of each shape and instance. Mesh files are not read: their shapes are taken to
/// lie at the transformed origin.
Vec3d render_origin(const Description& description);

/// The description with everything moved by `-origin`.
Description moved_to(const Description& description, Vec3d origin);

}  // namespace sheaf
