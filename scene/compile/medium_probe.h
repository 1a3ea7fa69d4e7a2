// Finds the medium that contains a point, by probe rays.
#pragma once

#include "scene/tables/scene.h"

namespace sheaf {

/// The medium at `p` (world space): 0 for vacuum, else 1 + its row. A point is inside a shape with an interior if a ray
/// from it leaves the shape before entering it. Of several shapes, the first one left counts, which is the innermost.
/// Sixteen rays in all directions vote. `ignored`: a shape that rays pass through. `default_value`: the medium outside
/// of all shapes.
std::uint32_t medium_at(const SceneView& scene, Vec3f p, std::uint32_t ignored, std::uint32_t default_value);

/// The medium around a shape: the majority of medium_at() just outside of it, ignoring the shape itself.
std::uint32_t medium_around(const SceneView& scene, std::uint32_t shape, std::uint32_t default_value);

/// The medium that surrounds the scene: the near side of the first boundary hit by rays from far outside.
/// `default_value` if no ray hits a boundary.
std::uint32_t medium_outside(const SceneView& scene, std::uint32_t default_value);

}  // namespace sheaf
