// Height fields from textures that are looked up.
#pragma once

#include "scene/tables/texture.h"

namespace sheaf {

/// The mesh of a height field, with its heights from the texture. Throws SceneError where the texture has no values
/// without a shape (mesh attributes, wireframes), values that are not finite, or where there are too few or too many
/// places.
Mesh sample_height_field(const HeightFieldShape& field, const CompiledTextures& textures);

}  // namespace sheaf
