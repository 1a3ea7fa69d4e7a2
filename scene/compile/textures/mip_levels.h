// Mip levels of images that give colors (Williams 1983, "Pyramidal Parametrics").
#pragma once

#include "scene/tables/material_tables.h"
#include "scene/tables/texture.h"

#include <functional>

namespace sheaf {

/// Adds mip levels to the bilinear images that materials use as reflectances only, directly or through other textures.
/// A texel is the mean of the texels of the previous level that it covers, by area and of linear values. Levels have
/// the format of the image. Bytes are rounded up or down at random, as a function of the texel's position, so that
/// means over several texels do not change. Other images have no levels: normals, roughness, complex indices of
/// refraction and opacities do not act linearly, so that their mean is not the mean of what they cause. Returns the
/// function that computes the texels, which may run beside readers of the tables and after these are moved, but must
/// finish before the levels are looked up.
[[nodiscard]] std::function<void()> add_mip_levels(const MaterialTables& materials, TextureTables& textures);

}  // namespace sheaf
