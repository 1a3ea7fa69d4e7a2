// Materials that both dialects spell alike: the choice of plugin, diffuse, metals, dielectrics and plastics.
#include "scene/read_bsdf.h"

#include "scene/dialects.h"
#include "scene/metals.h"
#include "scene/named_ior.h"

#include <algorithm>

namespace sheaf {

namespace {

constexpr float kMinAlpha = 1e-4f;
const SpectrumDescription kOne = SpectrumDescription::constant(1);

SpectrumInput read_reflectance(Properties& p, const char* name, SpectrumInput otherwise) {
  return p.spectrum_input(name, std::move(otherwise), SpectrumRole::kReflectance);
}

/// `spectrum` divided by a number.
SpectrumDescription divided(SpectrumDescription spectrum, float by) {
  using S = SpectrumDescription;
  if (auto* constant = std::get_if<S::Constant>(&spectrum.value)) constant->value /= by;
  if (auto* rgb = std::get_if<S::Rgb>(&spectrum.value)) rgb->value = rgb->value * (1 / by);
  if (auto* table = std::get_if<S::Table>(&spectrum.value))
    for (float& v : table->values) v /= by;
  return spectrum;
}

ConductorDescription::Ior named_metal(Properties& p, const std::string& name) {
  const std::span<const MetalSample> samples = find_metal(name);
  if (samples.empty()) {
    std::vector<std::string> known = metal_names();
    known.emplace_back("none");
    std::string list;
    for (const std::string& metal : known) list += (list.empty() ? "" : ", ") + metal;
    p.fail_at("material", "is " + in_quotes(name) + ", expected the name of a metal" + did_you_mean(name, known) +
                              " (known: " + list + "); others can be given by 'eta' and 'k'");
  }
  SpectrumDescription::Table eta, k;
  for (const MetalSample& sample : samples) {
    eta.wavelengths.push_back(sample.wavelength);
    eta.values.push_back(sample.eta);
    k.wavelengths.push_back(sample.wavelength);
    k.values.push_back(sample.k);
  }
  return {SpectrumDescription{std::move(eta)}, SpectrumDescription{std::move(k)}};
}

/// The metal relative to the dielectric around it.
SpectrumInput relative(Properties& p, SpectrumInput ior, float ext_eta) {
  if (auto* spectrum = std::get_if<SpectrumDescription>(&ior)) return divided(std::move(*spectrum), ext_eta);
  if (p.has("ext_eta")) p.fail_at("ext_eta", "is given beside a texture of 'eta' or 'k', which it cannot divide");
  return ior;
}

ConductorDescription read_conductor(Properties& p, bool before_version_2) {
  ConductorDescription result;
  result.specular_reflectance = read_reflectance(p, "specular_reflectance", kOne);
  const auto eta = p.find_spectrum_input("eta", SpectrumRole::kIor), k = p.find_spectrum_input("k", SpectrumRole::kIor);
  const std::optional<std::string> material = p.find_string("material");
  if (eta || k) {
    if (!eta || !k) p.fail(std::string("has '") + (eta ? "eta" : "k") + "' alone, expected both 'eta' and 'k'");
    if (material && *material != "none")
      p.fail_at("material", "is given beside 'eta' and 'k', expected one or the other");
    result.ior = {*eta, *k};
  } else if (const std::string name = material.value_or(before_version_2 ? "Cu" : "none"); name != "none") {
    result.ior = named_metal(p, name);
  }
  if (before_version_2) {
    const float ext_eta = read_ior(p, "ext_eta", 1.000277f);
    if (result.ior) result.ior = {relative(p, result.ior->eta, ext_eta), relative(p, result.ior->k, ext_eta)};
  }
  return result;
}

DielectricDescription read_dielectric(Properties& p) {
  DielectricDescription result;
  result.int_ior = read_ior(p, "int_ior", result.int_ior);
  result.ext_ior = read_ior(p, "ext_ior", result.ext_ior);
  result.specular_reflectance = read_reflectance(p, "specular_reflectance", kOne);
  result.specular_transmittance = read_reflectance(p, "specular_transmittance", kOne);
  result.thin = p.type() == "thindielectric";
  if (p.type() == "roughdielectric") result.roughness = read_roughness(p);
  return result;
}

PlasticDescription read_plastic(Properties& p) {
  PlasticDescription result;
  result.int_ior = read_ior(p, "int_ior", result.int_ior);
  result.ext_ior = read_ior(p, "ext_ior", result.ext_ior);
  result.diffuse_reflectance = read_reflectance(p, "diffuse_reflectance", result.diffuse_reflectance);
  result.specular_reflectance = read_reflectance(p, "specular_reflectance", kOne);
  result.nonlinear = p.boolean("nonlinear", false);
  if (p.type() == "plastic") return result;
  for (const char* name : {"alpha", "alpha_u", "alpha_v"})
    if (p.is_texture(name)) p.fail_at(name, "is a texture, expected a number: the roughness is the same everywhere");
  result.roughness = read_roughness(p);
  if (result.roughness->alpha_u != result.roughness->alpha_v)
    p.fail_at("alpha_v", "differs from 'alpha_u', expected the same roughness along and across");
  return result;
}

/// `diffuse` has one more name for its parameter in Mitsuba before 2.
DiffuseDescription read_diffuse(Properties& p) {
  const DiffuseDescription otherwise;
  if (p.has("diffuse_reflectance") && !p.has("reflectance"))
    return {read_reflectance(p, "diffuse_reflectance", otherwise.reflectance)};
  return {read_reflectance(p, "reflectance", otherwise.reflectance)};
}

}  // namespace

float read_ior(Properties& p, const char* property, float otherwise) {
  if (!p.is_string(property)) return p.number(property, otherwise, kPositive);
  const std::string name = *p.find_string(property);
  if (const std::optional<float> ior = find_ior(name)) return *ior;
  p.fail_at(property, "is " + in_quotes(name) + ", expected a number or the name of a material" +
                          did_you_mean(name, ior_names()));
}

ScalarInput read_alpha(Properties& p, const char* name, ScalarInput otherwise) {
  ScalarInput alpha = p.scalar_input(name, otherwise, kNotNegative);
  if (float* constant = std::get_if<float>(&alpha)) *constant = std::max(*constant, kMinAlpha);
  return alpha;
}

RoughnessDescription read_roughness(Properties& p) {
  RoughnessDescription result;
  const std::string distribution = p.find_string("distribution").value_or("beckmann");
  if (distribution == "ggx") {
    result.distribution = RoughnessDescription::Distribution::kGgx;
  } else if (distribution != "beckmann") {
    const bool phong = distribution == "phong" || distribution == "as";
    p.fail_at("distribution", "is " + in_quotes(distribution) + ", expected beckmann or ggx" +
                                  (phong ? ": distributions of Phong's kind are not supported" : ""));
  }
  const bool along = p.has("alpha_u"), across = p.has("alpha_v");
  if (along != across) p.fail(std::string("has 'alpha_") + (along ? "u" : "v") + "' alone, expected both or 'alpha'");
  if (along && p.has("alpha")) p.fail_at("alpha", "is given beside 'alpha_u' and 'alpha_v', expected one or the other");
  result.alpha_u = read_alpha(p, along ? "alpha_u" : "alpha", result.alpha_u);
  result.alpha_v = along ? read_alpha(p, "alpha_v", result.alpha_v) : result.alpha_u;
  p.accept({"sample_visible"});
  return result;
}

const std::vector<std::string>& shared_bsdf_names() {
  static const std::vector<std::string> kNames = {
      "blendbsdf",       "bumpmap",      "conductor",     "dielectric", "diffuse",        "mask",
      "normalmap",       "null",         "plastic",       "principled", "principledthin", "roughconductor",
      "roughdielectric", "roughplastic", "thindielectric", "twosided"};
  return kNames;
}

bool read_shared_bsdf(Properties& p, const BsdfDialect& dialect, MaterialDescription& material) {
  const std::string& type = p.type();
  if (type == "diffuse") {
    material.model = read_diffuse(p);
  } else if (type == "conductor" || type == "roughconductor") {
    ConductorDescription conductor = read_conductor(p, dialect.before_version_2);
    if (type == "roughconductor") conductor.roughness = read_roughness(p);
    material.model = std::move(conductor);
  } else if (type == "dielectric" || type == "thindielectric" || type == "roughdielectric") {
    material.model = read_dielectric(p);
  } else if (type == "plastic" || type == "roughplastic") {
    material.model = read_plastic(p);
  } else if (type == "principled") {
    material.model = read_principled(p);
  } else if (type == "principledthin") {
    material.model = read_principled_thin(p);
  } else if (type == "null") {
    material.model = NullDescription{};
  } else if (type == "twosided") {
    material.model = read_two_sided(p, dialect);
  } else if (type == "mask") {
    material.model = read_mask(p, dialect);
  } else if (type == "blendbsdf") {
    material.model = read_blend(p, dialect);
  } else if (type == "bumpmap" || type == "normalmap") {
    material.fix_invalid_normals = p.boolean("flip_invalid_normals", true);
    material.soften_terminator = p.boolean("use_shadowing_function", true);
    if (type == "bumpmap") material.model = read_bump_map(p, dialect);
    if (type == "normalmap") material.model = read_normal_map(p, dialect);
  } else {
    return false;
  }
  return true;
}

MaterialId add_material_of(Properties& p, MaterialDescription material) {
  p.finish();
  material.where = p.where();
  if (const std::string* id = p.element().find_attribute("id")) material.id = *id;
  return add_material(p.context(), std::move(material));
}

}  // namespace sheaf
