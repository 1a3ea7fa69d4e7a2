// Bounds of lights for the light tree: what the kinds (scene/compile/lights/) share, and what tests ask for.
#pragma once

#include "scene/tables/light_tree.h"
#include "scene/tables/scene.h"

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

/// A light with a frame, which gives off `power` W, as a spot that is as bright everywhere within the angle of cosine
/// `cos_total` from its axis; in all directions if the frame stretches.
LightBounds frame_light_bounds(const LightFrameRow& frame, Vec3f position, double cos_total, double power);

/// LightBounds::power for a peak of the intensity (W / sr). Like the weights by which lights are chosen without a tree:
/// positive and finite however large the light.
float peak_power(double peak_intensity);

/// The bounds of light `light` of the scene, which gives off `power` W, averaged over R, G and B. The light must be
/// bounded; see is_infinite().
LightBounds bounds_of_light(const SceneView& scene, std::uint32_t light, double power);

}  // namespace sheaf
