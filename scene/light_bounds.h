// Bounds of lights, kind by kind, for the light tree.
#pragma once

#include "scene/light_tree.h"
#include "scene/scene.h"

namespace sheaf {

/// A mesh that emits `radiance` (W / (m^2 sr), averaged over R, G and B) on the side of its normals. Triangles without
/// area are left out.
LightBounds mesh_light_bounds(std::span<const LightTriangleRow> triangles, float radiance);

/// A sphere, disk or cylinder that emits on the side of its normals.
LightBounds quadric_light_bounds(const QuadricRow& row, float radiance);

/// A point light of `intensity` (W / sr) in all directions.
LightBounds point_light_bounds(Vec3f position, float intensity);

/// A point light of at most `intensity` (W / sr) in directions within the angle of cosine `cos_total` from the unit
/// vector `axis`, and none beyond.
LightBounds spot_light_bounds(Vec3f position, Vec3f axis, float cos_total, float intensity);

/// The bounds of light `light` of the scene, which gives off `power` W, averaged over R, G and B. The light must be
/// bounded; see is_infinite().
LightBounds bounds_of_light(const SceneView& scene, std::uint32_t light, double power);

}  // namespace sheaf
