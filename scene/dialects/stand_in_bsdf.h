// What a material that is not known looks like: the nearest that is.
#pragma once

#include "scene/dialects/dialects.h"

#include <functional>

namespace sheaf {

/// Reads a <bsdf> by `read`, which appends a material. If the context is lenient, what cannot be read is replaced: by a
/// material that it holds, by the known plugin whose name or parameters are most alike, or by a diffuse surface in its
/// first colour. Throws SceneError if not lenient.
MaterialId read_bsdf_leniently(const XmlElement& bsdf, ReadContext& context,
                               const std::function<MaterialId(const XmlElement&)>& read);

}  // namespace sheaf
