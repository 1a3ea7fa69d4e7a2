// Nori's microfacet BRDF: reading, and the row.
#include "scene/materials/nori_microfacet.h"

#include "scene/materials/reading.h"
#include "scene/materials/row_builder.h"

namespace sheaf {

NoriMicrofacetDescription NoriMicrofacetDescription::read(Properties& p, const BsdfDialect&) {
  NoriMicrofacetDescription result;
  result.int_ior = read_ior(p, "intIOR", result.int_ior);
  result.ext_ior = read_ior(p, "extIOR", result.ext_ior);
  result.alpha = read_alpha(p, first_of(p, {"alpha", "m_alpha"}), result.alpha);
  result.kd = read_reflectance(p, first_of(p, {"kd", "albedo"}), result.kd);
  return result;
}

MaterialRow NoriMicrofacetDescription::make_row(RowContext& context) const {
  MaterialRowBuilder<NoriMicrofacetParameters> m{context};
  m.set(m.p.kd, kd);
  m.set(m.p.alpha, alpha);
  m.p.eta = int_ior / ext_ior;
  return m.row<NoriMicrofacetClosure>();
}

}  // namespace sheaf
