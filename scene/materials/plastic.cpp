// Plastics: reading, and the row.
#include "scene/materials/plastic.h"

#include "scene/materials/reading.h"
#include "scene/materials/row_builder.h"

#include <algorithm>

namespace sheaf {

namespace {

template <template <class> class Parameters>
void set_plastic(MaterialRowBuilder<Parameters>& m, const PlasticDescription& d) {
  m.p.eta = d.int_ior / d.ext_ior;
  m.set(m.p.diffuse, d.diffuse_reflectance);
  m.set(m.p.specular, d.specular_reflectance);
  m.p.nonlinear = d.nonlinear ? 1 : 0;
}

}  // namespace

PlasticDescription PlasticDescription::read_smooth(Properties& p, const BsdfDialect&) {
  PlasticDescription result;
  result.int_ior = read_ior(p, "int_ior", result.int_ior);
  result.ext_ior = read_ior(p, "ext_ior", result.ext_ior);
  result.diffuse_reflectance = read_reflectance(p, "diffuse_reflectance", result.diffuse_reflectance);
  result.specular_reflectance = read_reflectance(p, "specular_reflectance", result.specular_reflectance);
  result.nonlinear = p.boolean("nonlinear", false);
  return result;
}

PlasticDescription PlasticDescription::read_rough(Properties& p, const BsdfDialect& dialect) {
  PlasticDescription result = read_smooth(p, dialect);
  result.roughness = read_uniform_roughness(p);
  return result;
}

PlasticDescription PlasticDescription::read_polarized(Properties& p, const BsdfDialect& dialect) {
  PlasticDescription result = read_rough(p, dialect);
  note_polarization(p);
  return result;
}

MaterialRow PlasticDescription::make_row(RowContext& context) const {
  if (!roughness) {
    MaterialRowBuilder<PlasticParameters> m{context};
    set_plastic(m, *this);
    m.p.internal_reflectance = smooth_coat_internal_reflectance(m.p.eta);
    return m.row<PlasticClosure>();
  }
  MaterialRowBuilder<RoughPlasticParameters> m{context};
  set_plastic(m, *this);
  m.p.alpha = uniform_roughness(*roughness);
  const RoughCoat coat = context.coats.coat(roughness->distribution, m.p.alpha, m.p.eta);
  m.p.internal_reflectance = coat.internal_reflectance;
  std::copy(coat.transmittance.begin(), coat.transmittance.end(), m.p.transmittance);
  return roughness->is_ggx() ? m.row<RoughPlasticGgxClosure>() : m.row<RoughPlasticBeckmannClosure>();
}

}  // namespace sheaf
