// Height fields sampled from textures.
#pragma once

#include "scene/description/shapes.h"
#include "scene/tables/texture.h"

namespace sheaf {

/// Makes the mesh of a height field with heights from its texture. Throws SceneError if the texture needs a shape (mesh
/// attributes, wireframes), has non-finite values, or if there are too few or too many samples.
Mesh sample_height_field(const HeightFieldShape& field, const TextureTables& textures);

}  // namespace sheaf
