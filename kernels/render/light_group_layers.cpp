#include "kernels/render/light_group_layers.h"

#include "core/io/error.h"
#include "kernels/render/render_settings.h"
#include "scene/scene.h"

#include <fmt/format.h>

namespace sheaf {

LightGroupLayers light_group_layers(const Scene& scene, const RenderSettings& settings) {
  if (!settings.light_groups) return {};
  LightGroupLayers layers{scene.names().lights, {}};
  // Photon maps mix the light of all groups.
  if (scene.names().has_other_light || settings.integrator.traits().has_photon_maps())
    layers.names.emplace_back("other");
  if (layers.names.size() > kMaxLightGroups)
    throw Error(ExitCode::kUsage,
                fmt::format("the scene has {} light groups, expected at most {}; lights with the same id form one "
                            "group, and so do lights without an id",
                            layers.names.size(), kMaxLightGroups));
  if (layers.names.empty()) return layers;
  for (const std::uint32_t light : scene.names().light_of_row)
    layers.group_of_light.push_back(static_cast<std::uint16_t>(light));
  return layers;
}

}  // namespace sheaf
