// Nearest hits of rays, as arrays.
#pragma once

#include "core/math/vec3d.h"
#include "scene/tables/scene_view.h"

#include <cstdint>
#include <string>
#include <vector>

namespace sheaf {

/// Nearest hits, one element per ray. Misses have an infinite distance, kNone in `shape`, and zeros elsewhere.
struct RayHits {
  std::vector<float> distance;                  ///< in units of the direction's length
  std::vector<Vec3d> position;                  ///< world space
  std::vector<Vec3f> normal, shading_normal;    ///< unit length, on the front of the surface
  std::vector<float> uv;                        ///< pairs
  std::vector<float> barycentric;               ///< pairs: weights of the second and third vertex; meshes only
  std::vector<std::uint32_t> shape, primitive;  ///< row of the shape; triangle, segment or cell
  std::vector<std::uint32_t> instance;          ///< row of the instance; kNone: not instanced
};

/// Traces rays at the time when the shutter opens. `origins`: world space. `directions`: as long as `origins`.
/// Coordinates must be finite and at most 1e18 in absolute value, directions not zero.
RayHits trace_rays(const SceneView& scene, const std::vector<Vec3d>& origins, const std::vector<Vec3f>& directions);

}  // namespace sheaf
