// Hair: reading, and the row.
#include "scene/materials/hair.h"

#include "scene/materials/reading.h"
#include "scene/materials/row_builder.h"

namespace sheaf {

namespace {

/// Absorption by melanin, per fiber radius and unit of concentration, in linear Rec.709 (d'Eon et al. 2011; PBR 9.9).
const SpectrumDescription kEumelanin = SpectrumDescription::rgb(0.419f, 0.697f, 1.37f);
const SpectrumDescription kPheomelanin = SpectrumDescription::rgb(0.187f, 0.4f, 1.05f);

}  // namespace

/// Melanin determines the absorption unless `sigma_a` is present.
HairDescription HairDescription::read(Properties& p, const BsdfDialect&) {
  HairDescription result;
  if (auto sigma_a = p.find_spectrum_input("sigma_a", SpectrumRole::kIor)) {
    for (const char* melanin : {"eumelanin", "pheomelanin"})
      if (p.has(melanin)) p.report_conflict(melanin, "'sigma_a'");
    result.color = Absorption{*std::move(sigma_a), 1};
  } else {
    Melanin melanin;
    melanin.eumelanin = p.scalar_input("eumelanin", melanin.eumelanin, kNotNegative);
    melanin.pheomelanin = p.scalar_input("pheomelanin", melanin.pheomelanin, kNotNegative);
    result.color = melanin;
  }
  const float scale = p.number("scale", 1, kNotNegative);
  if (auto* absorption = std::get_if<Absorption>(&result.color)) absorption->scale = scale;
  read_unit(p, "longitudinal_roughness", result.longitudinal_roughness);
  read_unit(p, "azimuthal_roughness", result.azimuthal_roughness);
  result.scale_tilt = p.number("scale_tilt", result.scale_tilt);
  result.int_ior = read_ior(p, "int_ior", result.int_ior);
  result.ext_ior = read_ior(p, "ext_ior", result.ext_ior);
  return result;
}

MaterialRow HairDescription::make_row(RowContext& context) const {
  MaterialRowBuilder<HairParameters> m{context};
  // Set the absorption
  if (const auto* by = std::get_if<Melanin>(&color)) {
    m.set(m.p.eumelanin_absorption, kEumelanin, TextureRole::kUnbounded);
    m.set(m.p.pheomelanin_absorption, kPheomelanin, TextureRole::kUnbounded);
    m.set(m.p.eumelanin, by->eumelanin);
    m.set(m.p.pheomelanin, by->pheomelanin);
  }
  if (const auto* by = std::get_if<Absorption>(&color)) {
    m.set(m.p.absorption, by->sigma_a, TextureRole::kUnbounded);
    m.p.scale = by->scale;
  }
  if (const auto* by = std::get_if<Reflectance>(&color)) {
    m.set(m.p.absorption, by->color);
    m.p.by_reflectance = 1;
  }
  // Set roughness, tilt and index of refraction
  m.set(m.p.longitudinal_roughness, longitudinal_roughness);
  m.set(m.p.azimuthal_roughness, azimuthal_roughness);
  m.p.tilt = scale_tilt * (kPi / 180);
  m.p.eta = int_ior / ext_ior;
  m.p.fourth = context.set != nullptr ? 1 : 0;
  MaterialRow row = m.row<HairClosure>();
  row.flags |= kNeedsUv;  // the fiber is along the tangent
  return row;
}

}  // namespace sheaf
