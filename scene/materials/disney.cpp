// Disney's BRDF of 2012: the row.
#include "scene/materials/disney.h"

#include "scene/materials/row_builder.h"

namespace sheaf {

MaterialRow DisneyDescription::make_row(RowContext& context) const {
  MaterialRowBuilder<DisneyParameters> m{context};
  m.set_declared(*this);
  m.set_base_luminance(base_color, {specular_tint, sheen_tint}, TextureRole::kBurleyLuminance);
  return with_tangent(m.row<DisneyClosure>(), anisotropic);
}

}  // namespace sheaf
