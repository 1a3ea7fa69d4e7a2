// Emission of surfaces with an opacity, for dialects in which opacity covers emission as it covers reflection.
#pragma once

#include "scene/description.h"

namespace sheaf {

/// The emission of a shape, as in ShapeDescription.
struct CoveredEmission {
  std::optional<SpectrumInput> radiance;  ///< empty: does not emit
  std::optional<TextureId> scale;         ///< ShapeDescription::radiance_scale
};

/// Returns `radiance` times the opacity of a surface: that of its material if it is a mask, otherwise 1. Adds the
/// textures that it needs.
CoveredEmission covered_emission(Description& description, SpectrumInput radiance, MaterialId material);

}  // namespace sheaf
