// Replacement of unsupported materials by the most similar supported one.
#pragma once

#include "scene/xml/properties.h"

#include <functional>

namespace sheaf {

/// Reads a <bsdf> by `read`, which appends a material. If the context is lenient, replaces an unreadable material. The
/// replacement is a nested material, the known plugin with the most similar name or parameters, or a diffuse surface in
/// its first colour. Throws SceneError if not lenient.
MaterialId read_bsdf_leniently(const XmlElement& bsdf, ReadContext& context,
                               const std::function<MaterialId(const XmlElement&)>& read);

}  // namespace sheaf
