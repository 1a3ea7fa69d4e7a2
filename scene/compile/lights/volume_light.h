// Emitting media as lights.
#pragma once

#include "scene/compile/light.h"
#include "scene/lights/volume_light.h"

namespace sheaf {

/// A medium as a light, with the data for sampling points in it (kernels/lights/volume_light.h).
struct MediumLight {
  LightRow row;
  std::vector<AliasEntry> alias;  ///< over the cells
};

/// Makes the light of the medium in row `medium`; empty if it does not emit. `boxes`: bounding boxes of the shapes that
/// contain it. The alias table will start at `first_cell`.
std::optional<MediumLight> make_volume_light(const SceneView& scene, std::uint32_t medium,
                                             std::span<const GridBox> boxes, std::uint32_t first_cell);

}  // namespace sheaf
