// Names of light selectors, shared by all dialects and the command line, and the integrator properties that control
// light sampling.
#pragma once

#include "scene/xml/properties.h"

#include <string_view>

namespace sheaf {

/// Returns the selector `uniform`, `power` or `bvh`; nullopt for other names.
std::optional<LightSelector> find_light_selector(std::string_view name);

/// Returns all selector names.
std::vector<std::string> light_selector_names();

/// Returns the name of a selector.
const char* light_selector_name(LightSelector selector);

/// Returns the selector of this name. Throws Error (usage) for an unknown name; the message lists the nearest name and
/// all names.
LightSelector light_selector_from_name(std::string_view name);

/// Reads `light_sampler` (a name) and `candidates` (light samples per vertex; RIS keeps one). Throws SceneError.
void read_light_sampling(Properties& p, IntegratorSettings& integrator);

}  // namespace sheaf
