// Media that emit as lights.
#pragma once

#include "scene/compile/light.h"

namespace sheaf {

/// A medium as a light: what chooses points in it (kernels/lights/volume_light.h).
struct MediumLight {
  LightRow row;
  std::vector<AliasEntry> alias;  ///< over its cells
};

/// The light that the medium of row `medium` is; nothing if it does not emit. `boxes`: around
/// the shapes that hold it. The alias table is to stand at `first_cell`.
std::optional<MediumLight> make_volume_light(const SceneView& scene, std::uint32_t medium,
                                             std::span<const GridBox> boxes, std::uint32_t first_cell);

}  // namespace sheaf
