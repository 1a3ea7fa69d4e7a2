// Disney's BRDF of 2012: reading, and the row.
#include "scene/materials/disney.h"

#include "scene/materials/reading.h"
#include "scene/materials/row_builder.h"

namespace sheaf {

DisneyDescription DisneyDescription::read(Properties& p, const BsdfDialect&) {
  DisneyDescription result;
  result.base_color = read_reflectance(p, first_of(p, {"baseColor", "albedo"}), result.base_color);
  read_unit(p, "metallic", result.metallic);
  read_unit(p, "subsurface", result.subsurface);
  read_unit(p, "specular", result.specular);
  read_unit(p, "specularTint", result.specular_tint);
  read_unit(p, "roughness", result.roughness);
  read_unit(p, "anisotropic", result.anisotropic);
  read_unit(p, "sheen", result.sheen);
  read_unit(p, "sheenTint", result.sheen_tint);
  read_unit(p, "clearcoat", result.clearcoat);
  read_unit(p, "clearcoatGloss", result.clearcoat_gloss);
  return result;
}

MaterialRow DisneyDescription::make_row(RowContext& context) const {
  MaterialRowBuilder<DisneyParameters> m{context};
  m.set(m.p.base_color, base_color);
  m.set(m.p.metallic, metallic);
  m.set(m.p.subsurface, subsurface);
  m.set(m.p.specular, specular);
  m.set(m.p.specular_tint, specular_tint);
  m.set(m.p.roughness, roughness);
  m.set(m.p.anisotropic, anisotropic);
  m.set(m.p.sheen, sheen);
  m.set(m.p.sheen_tint, sheen_tint);
  m.set(m.p.clearcoat, clearcoat);
  m.set(m.p.clearcoat_gloss, clearcoat_gloss);
  if (specular_tint != ScalarInput(0.0f) || sheen_tint != ScalarInput(0.0f))
    m.set_luminance(m.p.base_luminance, m.p.base_color, base_color, TextureRole::kBurleyLuminance);
  return with_tangent(m.row<DisneyClosure>(), anisotropic);
}

}  // namespace sheaf
