// Ward's BRDF: reading, and the row.
#include "scene/materials/ward.h"

#include "core/io/name_table.h"
#include "scene/materials/reading.h"
#include "scene/materials/row_builder.h"

namespace sheaf {

WardDescription WardDescription::read(Properties& p, const BsdfDialect&) {
  static constexpr NameTable<Variant> kVariants{
      {{"ward", Variant::kWard}, {"ward-duer", Variant::kDuer}, {"balanced", Variant::kBalanced}}};
  WardDescription result;
  result.variant = p.choice("variant", kVariants, result.variant);
  result.diffuse_reflectance = read_reflectance(p, "diffuse_reflectance", result.diffuse_reflectance);
  result.specular_reflectance = read_reflectance(p, "specular_reflectance", result.specular_reflectance);
  const ScalarInput both = read_alpha(p, "alpha", result.alpha_u);
  result.alpha_u = read_alpha(p, "alpha_u", both);
  result.alpha_v = read_alpha(p, "alpha_v", both);
  limit_energy(p, result.diffuse_reflectance, result.specular_reflectance);
  return result;
}

MaterialRow WardDescription::make_row(RowContext& context) const {
  MaterialRowBuilder<WardParameters> m{context};
  m.set(m.p.diffuse, diffuse_reflectance);
  m.set(m.p.specular, specular_reflectance);
  m.set(m.p.alpha_u, alpha_u);
  m.set(m.p.alpha_v, alpha_v);
  m.p.variant = static_cast<std::uint32_t>(variant);
  MaterialRow row = m.row<WardClosure>();
  if (alpha_u != alpha_v) row.flags |= kNeedsUv;
  return row;
}

}  // namespace sheaf
