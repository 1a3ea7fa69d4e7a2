// Mitsuba's principledthin: reading, and the row.
#include "scene/materials/principled_thin.h"

#include "scene/materials/reading.h"
#include "scene/materials/row_builder.h"

namespace sheaf {

PrincipledThinDescription PrincipledThinDescription::read(Properties& p, const BsdfDialect&) {
  PrincipledThinDescription result;
  result.base_color = read_reflectance(p, "base_color", result.base_color);
  read_unit(p, "roughness", result.roughness);
  read_unit(p, "anisotropic", result.anisotropic);
  read_unit(p, "spec_trans", result.spec_trans);
  read_unit(p, "spec_tint", result.spec_tint);
  read_unit(p, "sheen", result.sheen);
  read_unit(p, "sheen_tint", result.sheen_tint);
  read_unit(p, "flatness", result.flatness);
  result.eta = p.scalar_input("eta", result.eta, kPositive);
  result.diff_trans = p.scalar_input("diff_trans", result.diff_trans, {0, 2, false});
  p.ignore({"specular_reflectance_sampling_rate", "specular_transmittance_sampling_rate",
            "diffuse_reflectance_sampling_rate", "diffuse_transmittance_sampling_rate"});
  return result;
}

MaterialRow PrincipledThinDescription::make_row(RowContext& context) const {
  MaterialRowBuilder<PrincipledThinParameters> m{context};
  m.set(m.p.base_color, base_color);
  m.set(m.p.roughness, roughness);
  m.set(m.p.anisotropic, anisotropic);
  m.set(m.p.spec_trans, spec_trans);
  m.set(m.p.eta, eta);
  m.set(m.p.spec_tint, spec_tint);
  m.set(m.p.sheen, sheen);
  m.set(m.p.sheen_tint, sheen_tint);
  m.set(m.p.flatness, flatness);
  m.set(m.p.diff_trans, diff_trans);
  if (spec_tint != ScalarInput(0.0f) || sheen_tint != ScalarInput(0.0f))
    m.set_luminance(m.p.base_luminance, m.p.base_color, base_color, TextureRole::kScalar);
  return with_tangent(m.row<PrincipledThinClosure>(), anisotropic);
}

}  // namespace sheaf
