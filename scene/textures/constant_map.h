// Textures of parameters that files may also give as constants.
#pragma once

#include "scene/xml/properties.h"

namespace sheaf {

/// Returns the texture of an input; for a constant, appends a constant texture.
TextureId texture_showing(const SpectrumInput& input, const SourceLocation& where, ReadContext& context);

}  // namespace sheaf
