// The Oren-Nayar BRDF: reading, and the row.
#include "scene/materials/rough_diffuse.h"

#include "scene/materials/reading.h"
#include "scene/materials/row_builder.h"

namespace sheaf {

RoughDiffuseDescription RoughDiffuseDescription::read(Properties& p, const BsdfDialect&) {
  RoughDiffuseDescription result;
  const char* name = p.has("diffuse_reflectance") && !p.has("reflectance") ? "diffuse_reflectance" : "reflectance";
  result.reflectance = read_reflectance(p, name, result.reflectance);
  result.alpha = p.scalar_input("alpha", result.alpha, kNotNegative);
  result.fast = p.boolean("use_fast_approx", false);
  return result;
}

MaterialRow RoughDiffuseDescription::make_row(RowContext& context) const {
  MaterialRowBuilder<RoughDiffuseParameters> m{context};
  m.set(m.p.reflectance, reflectance);
  m.set(m.p.alpha, alpha);
  m.p.fast = fast ? 1.0f : 0.0f;
  return m.row<RoughDiffuseClosure>();
}

}  // namespace sheaf
