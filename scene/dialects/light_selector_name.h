// The names of light selectors, in all dialects and on the command line, and the properties of integrators that say how
// lights are sampled.
#pragma once

#include "scene/xml/properties.h"

#include <string_view>

namespace sheaf {

/// The selector called uniform, power or bvh; nothing for other names.
std::optional<LightSelector> find_light_selector(std::string_view name);

/// All names.
std::vector<std::string> light_selector_names();

/// The name of a selector.
const char* light_selector_name(LightSelector selector);

/// The selector of this name. Throws Error (usage) for an unknown one, with the nearest known one and all others.
LightSelector light_selector_from_name(std::string_view name);

/// Reads `light_sampler` (a name) and `candidates` (lights per vertex, of which resampling keeps one). Throws
/// SceneError.
void read_light_sampling(Properties& p, IntegratorDescription& integrator);

}  // namespace sheaf
