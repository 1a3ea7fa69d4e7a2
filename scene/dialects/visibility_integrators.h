// Integrators that look at shapes alone, whatever their materials and lights: ambient occlusion and average visibility.
#pragma once

#include "scene/description/description.h"

#include <string_view>

namespace sheaf {

/// Whether the name is of such an integrator: ao, its name in pbrt, ambientocclusion, or av.
bool is_visibility_integrator(std::string_view name);

/// All shapes become white and diffuse, emit nothing and hold nothing; no light is left. Boundaries that light does not
/// notice are left out, but for those in groups. `two_sided`: also surfaces seen from behind are white.
void make_white(Description& description, bool two_sided);

/// Makes the scene one whose image is what the integrator computes. ao: each point's share of the sky, by the cosine,
/// 0 where the camera sees nothing. av: the share of the directions around each point's normal, all alike, in which
/// nothing is nearer than `length` metres, 1 where the camera sees nothing. To be called once the scene is read.
void apply_visibility_integrator(std::string_view name, float length, bool two_sided, Description& description);

}  // namespace sheaf
