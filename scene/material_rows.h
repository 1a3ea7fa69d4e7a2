// One material that is no combination of others, as a row.
#pragma once

#include "scene/compile_materials.h"

namespace sheaf {

/// The row of a material that is neither composite nor two-sided nor mapped; its bindings are appended to `bindings`.
/// `back`, `bucket` and the choices are left to the caller.
MaterialRow make_material_row(const MaterialDescription& material, std::vector<TextureBinding>& bindings);

}  // namespace sheaf
