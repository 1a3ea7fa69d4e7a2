// Power and bounds of the lights of a scene, by which they are selected.
#pragma once

#include "scene/lights/list.h"

namespace sheaf {

/// Power of a light, W in R, G and B. For lights at infinity, the power that reaches the scene's bounding sphere.
/// Textures are averaged over a few thousand points.
Vec3f light_power(const SceneView& scene, std::uint32_t light);

/// light_power() of all lights. Lights of the same shape share integrals. With hundreds of integrals, each uses fewer
/// points, but at least 256.
std::vector<Vec3f> light_powers(const SceneView& scene);

/// Bounds of light `light` of the scene, with `power` in W, averaged over R, G and B. The light must be bounded; see
/// is_infinite().
LightBounds bounds_of_light(const SceneView& scene, std::uint32_t light, double power);

}  // namespace sheaf
