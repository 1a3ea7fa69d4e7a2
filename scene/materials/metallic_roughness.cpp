// The metallic-roughness material of glTF 2.0: the row.
#include "scene/materials/metallic_roughness.h"

#include "scene/materials/row_builder.h"

#include <cmath>

namespace sheaf {

namespace {

/// Reflectance at normal incidence (KHR_materials_ior).
float normal_reflectance_of(float eta) {
  if (std::isinf(eta)) return 1;
  const float root = (eta - 1) / (eta + 1);
  return root * root;
}

}  // namespace

MaterialRow MetallicRoughnessDescription::make_row(RowContext& context) const {
  MaterialRowBuilder<MetallicRoughnessParameters> m{context};
  m.set(m.p.base_color, base_color);
  m.set(m.p.specular_color, specular_color, TextureRole::kUnbounded);
  m.set(m.p.sheen_color, sheen_color);
  m.set(m.p.metallic, metallic);
  m.set(m.p.roughness, roughness);
  m.set(m.p.specular, specular);
  m.set(m.p.transmission, transmission);
  m.set(m.p.anisotropy, anisotropy);
  m.set(m.p.anisotropy_rotation, anisotropy_rotation);
  m.set(m.p.sheen_roughness, sheen_roughness);
  m.set(m.p.clearcoat, clearcoat);
  m.set(m.p.clearcoat_roughness, clearcoat_roughness);
  m.p.f0 = normal_reflectance_of(eta);
  m.p.is_thin = transmits() ? 1 : 0;
  MaterialRow row = with_tangent(m.row<MetallicRoughnessClosure>(), anisotropy);
  const bool is_rotated = anisotropy != ScalarInput(0.0f) && anisotropy_rotation != ScalarInput(0.0f);
  if (is_rotated) row.flags |= (m.word_of(m.p.anisotropy_rotation) + 1) << kRotationWordShift;
  return row;
}

}  // namespace sheaf
