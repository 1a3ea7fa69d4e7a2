// Which medium a point is in, found by looking around from it.
#pragma once

#include "scene/tables/scene.h"

namespace sheaf {

/// The medium at `p` (world space): 0 for vacuum, else 1 + its row. A point is in a shape with an interior if a ray
/// from it leaves the shape before it enters it; of several shapes the one that is left first counts, the innermost.
/// Sixteen rays in all directions vote. `ignored`: a shape that is looked through. `default_value`: the medium outside
/// of all.
std::uint32_t medium_at(const SceneView& scene, Vec3f p, std::uint32_t ignored, std::uint32_t default_value);

/// The medium around a shape: what medium_at() finds just outside of it, ignoring itself.
std::uint32_t medium_around(const SceneView& scene, std::uint32_t shape, std::uint32_t default_value);

/// The medium that surrounds the scene: what the first boundary that rays from far outside meet has on its near side.
/// `default_value`: where they meet none.
std::uint32_t medium_outside(const SceneView& scene, std::uint32_t default_value);

}  // namespace sheaf
