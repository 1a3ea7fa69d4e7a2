// Materials of Mitsuba before version 2: rough diffuse, Ward, Hanrahan-Krueger and coating.
#include "scene/data/measured_media.h"
#include "scene/dialects/common/read_bsdf.h"
#include "scene/dialects/common/read_phase.h"
#include "scene/dialects/common/read_spectrum.h"
#include "scene/xml/xml_values.h"

#include <algorithm>

namespace sheaf {

namespace {

const SpectrumDescription kOne = SpectrumDescription::constant(1);

SpectrumInput read_reflectance(Properties& p, const char* name, SpectrumInput default_value) {
  return p.spectrum_input(name, std::move(default_value), SpectrumRole::kReflectance);
}

/// Maximum of a spectrum per channel in linear Rec.709. For a table, returns its maximum value in all three channels.
Vec3f brightest(const SpectrumDescription& spectrum) {
  using S = SpectrumDescription;
  if (const auto* constant = std::get_if<S::Constant>(&spectrum.value))
    return {constant->value, constant->value, constant->value};
  if (const auto* rgb = std::get_if<S::Rgb>(&spectrum.value)) return rgb->value;
  float most = 0;
  if (const auto* table = std::get_if<S::Table>(&spectrum.value))
    for (const float v : table->values) most = std::max(most, v);
  return {most, most, most};
}

WardDescription::Variant read_variant(Properties& p) {
  using Variant = WardDescription::Variant;
  const std::string name = p.string("variant", "balanced");
  if (name == "ward") return Variant::kWard;
  if (name == "ward-duer") return Variant::kDuer;
  if (name == "balanced") return Variant::kBalanced;
  p.fail_at("variant", "is " + in_quotes(name) + ", expected ward, ward-duer or balanced" +
                           did_you_mean(name, {"ward", "ward-duer", "balanced"}));
}

/// Sets the coefficients of the measured medium that `material` names, by default skin1.
void read_material(Properties& p, HanrahanKruegerDescription& slab) {
  const std::string name = p.string("material", "skin1");
  const MeasuredMedium* found = find_measured_medium(name);
  if (found == nullptr)
    p.fail_at("material", "is " + in_quotes(name) + ", expected the name of a measured medium" +
                              did_you_mean(name, measured_medium_names()));
  slab.first = SpectrumDescription{SpectrumDescription::Rgb{found->sigma_s}};
  slab.second = SpectrumDescription{SpectrumDescription::Rgb{found->sigma_a}};
  slab.by_albedo = false;
}

/// Returns the mean cosine of the nested phase function, or 0 without one.
float read_mean_cosine(Properties& p) {
  const std::optional<PhaseId> id = find_phase(p);
  if (!id) return 0;
  const PhaseDescription& phase = p.context().description.phases[static_cast<std::size_t>(*id)];
  if (const auto* hg = std::get_if<HenyeyGreensteinDescription>(&phase.model)) return hg->g;
  if (std::holds_alternative<IsotropicPhaseDescription>(phase.model)) return 0;
  throw SceneError(phase.where, "phase function of 'hk' not supported, expected isotropic or hg");
}

}  // namespace

void limit_energy(Properties& p, SpectrumInput& diffuse, SpectrumInput& specular) {
  if (!p.boolean("ensure_energy_conservation", true)) return;
  auto* d = std::get_if<SpectrumDescription>(&diffuse);
  auto* s = std::get_if<SpectrumDescription>(&specular);
  if (d == nullptr || s == nullptr) return;
  const Vec3f sum = brightest(*d) + brightest(*s);
  const float most = std::max({sum.x, sum.y, sum.z});
  if (!(most > 1.0f)) return;
  constexpr float kMax = 0.99f;
  *d = scaled(std::move(*d), kMax / most);
  *s = scaled(std::move(*s), kMax / most);
  p.context().note(p.where(), "reflects up to " + std::to_string(most) +
                                  " of the light; its reflectances are scaled down so that they add up to 0.99");
}

RoughDiffuseDescription read_rough_diffuse(Properties& p) {
  RoughDiffuseDescription result;
  const char* name = p.has("diffuse_reflectance") && !p.has("reflectance") ? "diffuse_reflectance" : "reflectance";
  result.reflectance = read_reflectance(p, name, result.reflectance);
  result.alpha = p.scalar_input("alpha", result.alpha, kNotNegative);
  result.fast = p.boolean("use_fast_approx", false);
  return result;
}

WardDescription read_ward(Properties& p) {
  WardDescription result;
  result.variant = read_variant(p);
  result.diffuse_reflectance = read_reflectance(p, "diffuse_reflectance", result.diffuse_reflectance);
  result.specular_reflectance = read_reflectance(p, "specular_reflectance", result.specular_reflectance);
  const ScalarInput both = read_alpha(p, "alpha", result.alpha_u);
  result.alpha_u = read_alpha(p, "alpha_u", both);
  result.alpha_v = read_alpha(p, "alpha_v", both);
  limit_energy(p, result.diffuse_reflectance, result.specular_reflectance);
  return result;
}

HanrahanKruegerDescription read_hanrahan_krueger(Properties& p) {
  HanrahanKruegerDescription result;
  const auto sigma_t = p.find_spectrum_input("sigma_t", SpectrumRole::kIor);
  const auto sigma_s = p.find_spectrum_input("sigma_s", SpectrumRole::kIor);
  const auto sigma_a = p.find_spectrum_input("sigma_a", SpectrumRole::kIor);
  const auto albedo = p.find_spectrum_input("albedo", SpectrumRole::kReflectance);
  const bool pair = sigma_t || albedo, other = sigma_s || sigma_a;
  if (pair && other) p.fail("mixes 'sigmaT' and 'albedo' with 'sigmaS' and 'sigmaA', expected one of the pairs");
  if (pair != (sigma_t && albedo) || other != (sigma_s && sigma_a))
    p.fail("has one coefficient alone, expected 'sigmaS' and 'sigmaA', or 'sigmaT' and 'albedo'");
  if ((pair || other) && p.has("material"))
    p.fail_at("material", "is set together with coefficients, expected one of them");
  if (pair) result.first = *sigma_t, result.second = *albedo;
  if (other) result.first = *sigma_s, result.second = *sigma_a, result.by_albedo = false;
  if (!pair && !other) read_material(p, result);
  result.thickness = p.number("thickness", 1, kNotNegative);
  result.g = read_mean_cosine(p);
  return result;
}

CoatDescription read_coat(Properties& p, const BsdfDialect& dialect) {
  CoatDescription result;
  result.int_ior = read_ior(p, "int_ior", result.int_ior);
  result.ext_ior = read_ior(p, "ext_ior", result.ext_ior);
  result.thickness = p.number("thickness", result.thickness, kNotNegative);
  result.sigma_a = p.spectrum_input("sigma_a", result.sigma_a, SpectrumRole::kIor);
  result.specular_reflectance = read_reflectance(p, "specular_reflectance", kOne);
  if (p.type() == "roughcoating") result.roughness = read_uniform_roughness(p);
  const std::vector<const XmlElement*> nested = p.objects("bsdf");
  if (nested.size() != 1) p.fail("has " + std::to_string(nested.size()) + " nested <bsdf>, expected one");
  result.nested = dialect.nested(*nested[0]);
  const std::vector<MaterialDescription>& materials = p.context().description.materials;
  if (transmits(materials, result.nested))
    p.fail("has a nested material that transmits light (line " +
           std::to_string(materials[static_cast<std::size_t>(result.nested)].where.line) + ")");
  return result;
}

}  // namespace sheaf
