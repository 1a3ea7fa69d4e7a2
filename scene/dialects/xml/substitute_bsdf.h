// Replacement of unsupported materials by the most similar supported one.
#pragma once

#include "scene/xml/properties.h"

#include <functional>

namespace sheaf {

/// Reads a <bsdf> as `plugin` (null: of its own type), and appends a material. Throws SceneError.
using BsdfPluginReader = std::function<MaterialId(const XmlElement&, const char* plugin)>;

/// Reads a <bsdf> by `read`. Reports an unreadable material and replaces it: by a nested material, the known plugin
/// with the most similar name or parameters, or a diffuse surface in its first color.
MaterialId read_bsdf_or_substitute(const XmlElement& bsdf, ReadContext& context, const BsdfPluginReader& read);

}  // namespace sheaf
