// The environment of a model that comes without a scene: a floor, a sky, names of what is added, and default settings.
#pragma once

#include "scene/description.h"
#include "scene/dialects/model/model_view.h"

#include <array>
#include <string_view>

namespace sheaf {

/// Beginning of the names of shapes and lights that are added to a bare model.
inline constexpr std::string_view kStudioPrefix = "studio_";

/// Adds a two-sided diffuse material.
MaterialId add_two_sided(Description& description, DiffuseDescription diffuse);

/// Adds a disk below the box, perpendicular to the up axis, whose edge is near the horizon.
void add_floor(const std::array<Vec3d, 2>& box, const ModelView& view, Description& description);

/// Adds the environment map of the surroundings, or else a constant sky and a sun over the viewer's left shoulder.
void add_sky(const std::array<Vec3d, 2>& box, const ModelView& view, const ModelEnvironment& surroundings,
             Description& description);

/// Places the camera for a model that has neither cameras nor lights, and adds what surrounds it, with names that begin
/// with kStudioPrefix. `box`: its bounds. Its meshes must be in memory.
void add_studio(const std::array<Vec3d, 2>& box, const ModelView& view, const ModelEnvironment& surroundings,
                Description& description);

/// Sets the size of the image, the pixel filter and the number of samples.
void set_model_defaults(Description& description);

}  // namespace sheaf
