// Layers with the contribution of each light group.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace sheaf {

class Scene;
struct RenderSettings;

/// Maximum number of light groups with layers.
inline constexpr std::size_t kMaxLightGroups = 64;

/// The light groups of a scene that have layers.
struct LightGroupLayers {
  std::vector<std::string> names;
  std::vector<std::uint16_t> group_of_light;  ///< index of each light's group, by row of LightView::rows
};

/// No groups unless RenderSettings::light_groups. Throws Error (usage) for more than kMaxLightGroups.
LightGroupLayers light_group_layers(const Scene& scene, const RenderSettings& settings);

}  // namespace sheaf
