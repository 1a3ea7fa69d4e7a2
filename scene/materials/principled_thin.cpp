// Mitsuba's principledthin: reading, and the row.
#include "scene/materials/principled_thin.h"

#include "scene/materials/reading.h"
#include "scene/materials/row_builder.h"

namespace sheaf {

PrincipledThinDescription PrincipledThinDescription::read(Properties& p, const BsdfDialect&) {
  PrincipledThinDescription result;
  read_declared(p, result);
  p.ignore({"specular_reflectance_sampling_rate", "specular_transmittance_sampling_rate",
            "diffuse_reflectance_sampling_rate", "diffuse_transmittance_sampling_rate"});
  return result;
}

MaterialRow PrincipledThinDescription::make_row(RowContext& context) const {
  MaterialRowBuilder<PrincipledThinParameters> m{context};
  m.set_declared(*this);
  m.set_base_luminance(base_color, {spec_tint, sheen_tint}, TextureRole::kScalar);
  return with_tangent(m.row<PrincipledThinClosure>(), anisotropic);
}

}  // namespace sheaf
