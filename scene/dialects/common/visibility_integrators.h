// Integrators that depend on shapes alone, not on materials and lights: ambient occlusion and average visibility.
#pragma once

#include "scene/description/description.h"

#include <string_view>

namespace sheaf {

/// Whether the name is one of these: ao, ambientocclusion (the name in pbrt), or av.
bool is_visibility_integrator(std::string_view name);

/// Makes all shapes white, diffuse and non-emissive, removes media and all lights. Removes null interfaces, except
/// those in groups. `two_sided`: back sides are white, too.
void make_white(Description& description, bool two_sided);

/// Modifies the scene such that its image is what the integrator computes. ao: cosine-weighted visibility of the sky at
/// each point, 0 where the camera ray misses. av: fraction of the hemisphere around the normal, uniformly weighted,
/// without an occluder closer than `length` (m), 1 where the camera ray misses. Call it after the scene is read.
void apply_visibility_integrator(std::string_view name, float length, bool two_sided, Description& description);

}  // namespace sheaf
