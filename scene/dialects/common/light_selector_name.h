// Names of light selectors, shared by all dialects and the command line, and the integrator properties that control
// light sampling.
#pragma once

#include "scene/content/description.h"
#include "scene/xml/named_values.h"

namespace sheaf {

inline constexpr NameTable<LightSelector> kLightSelectors{
    {{"uniform", LightSelector::kUniform}, {"power", LightSelector::kPower}, {"bvh", LightSelector::kBvh}}};

/// Reads `light_sampler` (a name) and `candidates` (light samples per vertex; RIS keeps one). Throws SceneError.
void read_light_sampling(NamedValues& p, IntegratorSettings& integrator);

}  // namespace sheaf
