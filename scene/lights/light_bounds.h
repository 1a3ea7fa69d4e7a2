// Bounds of lights for the light tree: helpers shared by the kinds (scene/lights/), also used by tests.
#pragma once

#include "scene/surfaces/shape.h"
#include "scene/tables/light.h"
#include "scene/tables/light_tree.h"

#include <span>

namespace sheaf {

/// A mesh that emits `radiance` (W / (m^2 sr), averaged over R, G and B) on the side of its normals. Degenerate
/// triangles are ignored.
LightBounds mesh_light_bounds(std::span<const LightTriangleRow> triangles, float radiance);

/// A sphere, disk or cylinder that emits on the side of its normals.
LightBounds quadric_light_bounds(const QuadricRow& row, float radiance);

/// A point light with `intensity` (W / sr) in all directions.
LightBounds point_light_bounds(Vec3f position, float intensity);

/// A spot light at `position` with at most `intensity` (W / sr) within the angle of cosine `cos_total` from the unit
/// vector `axis`.
LightBounds spot_light_bounds(Vec3f position, Vec3f axis, float cos_total, float intensity);

/// A light with a frame and `power` W, as a spot light of constant intensity within the angle of cosine `cos_total`
/// from its axis. Unlimited if the frame distorts angles.
LightBounds frame_light_bounds(const LightFrameRow& frame, Vec3f position, double cos_total, double power);

/// LightBounds::power for a peak intensity (W / sr). Positive and finite for any light, like the weights for selection
/// without a tree.
float peak_power(double peak_intensity);

}  // namespace sheaf
