// Mip levels of images that give colors (Williams 1983, "Pyramidal Parametrics").
#pragma once

#include "scene/tables/material_tables.h"
#include "scene/tables/texture.h"

#include <functional>

namespace sheaf {

/// Adds mip levels to the bilinear images that materials use as reflectances only, directly or through other textures.
/// Levels have the format of the image. Other images have no levels: normals, roughness, complex indices of refraction
/// and opacities do not act linearly, so that their mean is not the mean of what they cause. Returns the function that
/// computes the texels of coarse levels, which may run beside readers of the tables and after these are moved, but must
/// finish before the levels are looked up.
[[nodiscard]] std::function<void()> add_mip_levels(const MaterialTables& materials, TextureTables& textures);

}  // namespace sheaf
