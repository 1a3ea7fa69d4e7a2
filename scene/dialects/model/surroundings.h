// The environment of a model that comes without a scene: a floor, a sky, and default settings.
#pragma once

#include "scene/description.h"
#include "scene/dialects/model/model_view.h"

#include <array>

namespace sheaf {

/// Adds a two-sided diffuse material.
MaterialId add_two_sided(Description& description, DiffuseDescription diffuse);

/// Adds a disk below the box, perpendicular to the up axis, whose edge is near the horizon.
void add_floor(const std::array<Vec3d, 2>& box, const ModelView& view, Description& description);

/// Adds the environment map of the surroundings, or else a constant sky and a sun over the viewer's left shoulder.
void add_sky(const std::array<Vec3d, 2>& box, const ModelView& view, const ModelEnvironment& surroundings,
             Description& description);

/// Sets the size of the image, the pixel filter and the number of samples.
void set_model_defaults(Description& description);

}  // namespace sheaf
