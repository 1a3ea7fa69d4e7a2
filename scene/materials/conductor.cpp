// Metals: reading, and the row.
#include "scene/materials/conductor.h"

#include "scene/data/metals.h"
#include "scene/materials/reading.h"
#include "scene/materials/row_builder.h"

#include <span>

namespace sheaf {

namespace {

/// Returns `spectrum` divided by a number.
SpectrumDescription divided(SpectrumDescription spectrum, float by) {
  using S = SpectrumDescription;
  if (auto* constant = std::get_if<S::Constant>(&spectrum.value)) constant->value /= by;
  if (auto* rgb = std::get_if<S::Rgb>(&spectrum.value)) rgb->value = rgb->value * (1 / by);
  if (auto* table = std::get_if<S::Table>(&spectrum.value))
    for (float& v : table->values) v /= by;
  return spectrum;
}

std::optional<ConductorDescription::Ior> named_metal(Properties& p, const std::string& name) {
  const std::span<const MetalSample> samples = find_metal(name);
  if (samples.empty()) {
    std::vector<std::string> known = metal_names();
    known.emplace_back("none");
    p.report_at("material",
                fmt::format("is {}, expected the name of a metal{} (known: {}); use 'eta' and 'k' for others",
                            in_quotes(name), did_you_mean(name, known), list_of(known)),
                SceneErrorCode::kUnknownName);
    return std::nullopt;
  }
  SpectrumDescription::Table eta, k;
  for (const MetalSample& sample : samples) {
    eta.wavelengths.push_back(sample.wavelength);
    eta.values.push_back(sample.eta);
    k.wavelengths.push_back(sample.wavelength);
    k.values.push_back(sample.k);
  }
  eta.equal_energy = k.equal_energy = true;
  return ConductorDescription::Ior{SpectrumDescription{std::move(eta)}, SpectrumDescription{std::move(k)}};
}

/// Returns an index of refraction relative to the surrounding dielectric.
SpectrumInput relative(Properties& p, SpectrumInput ior, float ext_eta) {
  if (auto* spectrum = std::get_if<SpectrumDescription>(&ior)) return divided(std::move(*spectrum), ext_eta);
  if (p.has("ext_eta")) p.report_conflict("ext_eta", "a texture of 'eta' or 'k'");
  return ior;
}

template <template <class> class Parameters>
void set_conductor(MaterialRowBuilder<Parameters>& m, const ConductorDescription& d) {
  const SpectrumInput none = SpectrumDescription::constant(0), mirror = SpectrumDescription::constant(1);
  m.set(m.p.eta, d.ior ? d.ior->eta : none, TextureRole::kUnbounded);
  m.set(m.p.k, d.ior ? d.ior->k : mirror, TextureRole::kUnbounded);
  // The fourth lane is unused in RGB mode. k = 1 keeps its Fresnel term finite.
  m.p.k.c3 = 1.0f;
  m.set(m.p.reflectance, d.specular_reflectance);
}

}  // namespace

ConductorDescription ConductorDescription::read_smooth(Properties& p, const BsdfDialect& dialect) {
  ConductorDescription result;
  result.specular_reflectance = read_reflectance(p, "specular_reflectance", result.specular_reflectance);
  const auto eta = p.find_spectrum_input("eta", SpectrumRole::kIor), k = p.find_spectrum_input("k", SpectrumRole::kIor);
  const std::string material = p.string("material", dialect.before_version_2 ? "Cu" : "none");
  if (eta || k) {
    if (!eta || !k) p.fail(fmt::format("has only '{}', expected both 'eta' and 'k'", eta ? "eta" : "k"));
    if (p.has("material") && material != "none") p.report_conflict("material", "'eta' and 'k'");
    result.ior = {*eta, *k};
  } else if (material != "none") {
    result.ior = named_metal(p, material);
  }
  if (dialect.before_version_2) {
    const float ext_eta = read_ior(p, "ext_eta", 1.000277f);
    if (result.ior) result.ior = {relative(p, result.ior->eta, ext_eta), relative(p, result.ior->k, ext_eta)};
  }
  return result;
}

ConductorDescription ConductorDescription::read_rough(Properties& p, const BsdfDialect& dialect) {
  ConductorDescription result = read_smooth(p, dialect);
  result.roughness = read_roughness(p);
  return result;
}

MaterialRow ConductorDescription::make_row(RowContext& context) const {
  if (!roughness) {
    MaterialRowBuilder<ConductorParameters> m{context};
    set_conductor(m, *this);
    return m.row<ConductorClosure>();
  }
  MaterialRowBuilder<RoughConductorParameters> m{context};
  set_conductor(m, *this);
  m.set_roughness(*roughness);
  return with_tangent(roughness->is_ggx() ? m.row<RoughConductorGgxClosure>() : m.row<RoughConductorBeckmannClosure>(),
                      *roughness);
}

}  // namespace sheaf
