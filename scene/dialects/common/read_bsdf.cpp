// Materials shared by the Nori and Mitsuba dialects: choice of the plugin, diffuse materials, metals, dielectrics and
// plastics.
#include "scene/dialects/common/read_bsdf.h"

#include "scene/data/glasses.h"
#include "scene/data/metals.h"
#include "scene/data/named_ior.h"
#include "scene/dialects/common/add_material.h"
#include "scene/xml/xml_values.h"

#include <algorithm>
#include <cmath>

namespace sheaf {

namespace {

constexpr float kMinAlpha = 1e-4f;
const SpectrumDescription kOne = SpectrumDescription::constant(1);

SpectrumInput read_reflectance(Properties& p, const char* name, SpectrumInput default_value) {
  return p.spectrum_input(name, std::move(default_value), SpectrumRole::kReflectance);
}

/// Returns `spectrum` divided by a number.
SpectrumDescription divided(SpectrumDescription spectrum, float by) {
  using S = SpectrumDescription;
  if (auto* constant = std::get_if<S::Constant>(&spectrum.value)) constant->value /= by;
  if (auto* rgb = std::get_if<S::Rgb>(&spectrum.value)) rgb->value = rgb->value * (1 / by);
  if (auto* table = std::get_if<S::Table>(&spectrum.value))
    for (float& v : table->values) v /= by;
  return spectrum;
}

std::string list_of(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  return list;
}

ConductorDescription::Ior named_metal(Properties& p, const std::string& name) {
  const std::span<const MetalSample> samples = find_metal(name);
  if (samples.empty()) {
    std::vector<std::string> known = metal_names();
    known.emplace_back("none");
    p.fail_at("material", "is " + in_quotes(name) + ", expected the name of a metal" + did_you_mean(name, known) +
                              " (known: " + list_of(known) + "); use 'eta' and 'k' for others");
  }
  SpectrumDescription::Table eta, k;
  for (const MetalSample& sample : samples) {
    eta.wavelengths.push_back(sample.wavelength);
    eta.values.push_back(sample.eta);
    k.wavelengths.push_back(sample.wavelength);
    k.values.push_back(sample.k);
  }
  eta.equal_energy = k.equal_energy = true;
  return {SpectrumDescription{std::move(eta)}, SpectrumDescription{std::move(k)}};
}

/// Returns an index of refraction relative to the surrounding dielectric.
SpectrumInput relative(Properties& p, SpectrumInput ior, float ext_eta) {
  if (auto* spectrum = std::get_if<SpectrumDescription>(&ior)) return divided(std::move(*spectrum), ext_eta);
  if (p.has("ext_eta")) p.fail_at("ext_eta", "is set together with a texture of 'eta' or 'k', expected one of them");
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
      p.fail_at("material", "is set together with 'eta' and 'k', expected one of them");
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

/// Index of refraction at the helium d line, at which glasses are catalogued.
float catalogue_ior(const Dispersion& dispersion) { return ior<Scalar>(dispersion, 587.56f); }

/// n = A + B / w^2 + C / w^4 with w in micrometres (Cauchy 1830).
Dispersion read_cauchy(Properties& p, const char* name) {
  const std::vector<float> numbers = read_numbers(p, name);
  if (numbers.size() < 2 || numbers.size() > 3)
    p.fail_at(name, "has " + std::to_string(numbers.size()) + " numbers, expected two or three: A, B, C");
  Dispersion result{Dispersion::Form::kPowers, numbers[0], {}};
  for (std::size_t i = 1; i < numbers.size(); ++i) result.terms[i - 1] = {numbers[i], -2.0f * static_cast<float>(i)};
  return result;
}

/// n^2 = 1 + sum of B w^2 / (w^2 - C) (Sellmeier 1871); all B, then all C.
Dispersion read_sellmeier(Properties& p, const char* name) {
  const std::vector<float> numbers = read_numbers(p, name);
  const std::size_t terms = numbers.size() / 2;
  Dispersion result;
  if (terms == 0 || numbers.size() % 2 != 0 || terms > result.terms.size())
    p.fail_at(name, "has " + std::to_string(numbers.size()) +
                        " numbers, expected B1 B2 ... C1 C2 ..., as many B as C, " +
                        std::to_string(result.terms.size()) + " of each at most");
  for (std::size_t i = 0; i < terms; ++i) result.terms[i] = {numbers[i], numbers[terms + i]};
  return result;
}

/// Reads the index of refraction of one side of a boundary and its dispersion; `side` is "int" or "ext".
/// `names_disperse`: whether named materials are dispersive; nullopt: all except those of find_ior().
void read_side(Properties& p, const std::string& side, std::optional<bool> names_disperse, float& index,
               std::optional<Dispersion>& dispersion) {
  const std::string plain = side + "_ior", cauchy = side + "_cauchy", sellmeier = side + "_sellmeier";
  const int given = int{p.has(plain.c_str())} + int{p.has(cauchy.c_str())} + int{p.has(sellmeier.c_str())};
  if (given > 1) p.fail("has more than one of '" + plain + "', '" + cauchy + "' and '" + sellmeier + "', expected one");
  if (p.has(cauchy.c_str())) dispersion = read_cauchy(p, cauchy.c_str());
  if (p.has(sellmeier.c_str())) dispersion = read_sellmeier(p, sellmeier.c_str());
  if (!dispersion) {
    index = read_ior(p, plain.c_str(), index);
    if (!p.is_string(plain.c_str())) return;
    const std::string name = *p.find_string(plain.c_str());
    const Dispersion* named = find_dispersion(name);
    if (named != nullptr && names_disperse.value_or(!find_ior(name))) dispersion = *named;
    return;
  }
  const char* name = p.has(cauchy.c_str()) ? cauchy.c_str() : sellmeier.c_str();
  for (float lambda = 360; lambda <= 830; ++lambda)
    if (const float n = ior<Scalar>(*dispersion, lambda); !(n > 0.0f) || !std::isfinite(n))
      p.fail_at(name, "has no index of refraction at " + std::to_string(static_cast<int>(lambda)) +
                          " nm, expected positive ones from 360 to 830 nm");
  index = catalogue_ior(*dispersion);
}

DielectricDescription read_dielectric(Properties& p, const BsdfDialect& dialect) {
  DielectricDescription result;
  std::optional<bool> names_disperse;
  if (dialect.names_disperse || p.has("dispersion")) names_disperse = p.boolean("dispersion", true);
  read_side(p, "int", names_disperse, result.int_ior, result.int_dispersion);
  read_side(p, "ext", names_disperse, result.ext_ior, result.ext_dispersion);
  if (p.has("dispersion") && *names_disperse && !result.int_dispersion && !result.ext_dispersion)
    p.fail_at("dispersion", "is true, but neither side has a dispersion formula, expected coefficients or one of " +
                                list_of(dispersion_names()));
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
  if (p.type() != "plastic") result.roughness = read_uniform_roughness(p);
  return result;
}

/// Reads hair; melanin determines the absorption unless `sigma_a` is present.
HairDescription read_hair(Properties& p) {
  HairDescription result;
  if (auto sigma_a = p.find_spectrum_input("sigma_a", SpectrumRole::kIor)) {
    for (const char* melanin : {"eumelanin", "pheomelanin"})
      if (p.has(melanin)) p.fail_at(melanin, "is set together with 'sigma_a', expected one of them");
    result.color = HairDescription::Absorption{*std::move(sigma_a), 1};
  } else {
    HairDescription::Melanin melanin;
    melanin.eumelanin = p.scalar_input("eumelanin", melanin.eumelanin, kNotNegative);
    melanin.pheomelanin = p.scalar_input("pheomelanin", melanin.pheomelanin, kNotNegative);
    result.color = std::move(melanin);
  }
  const float scale = p.number("scale", 1, kNotNegative);
  if (auto* absorption = std::get_if<HairDescription::Absorption>(&result.color)) absorption->scale = scale;
  const NumberRange unit{0, 1};
  result.longitudinal_roughness = p.scalar_input("longitudinal_roughness", result.longitudinal_roughness, unit);
  result.azimuthal_roughness = p.scalar_input("azimuthal_roughness", result.azimuthal_roughness, unit);
  result.scale_tilt = p.number("scale_tilt", result.scale_tilt);
  result.int_ior = read_ior(p, "int_ior", result.int_ior);
  result.ext_ior = read_ior(p, "ext_ior", result.ext_ior);
  return result;
}

template <DeclarativeBsdf Model> Model read_plain(Properties& p) {
  Model model;
  std::size_t k = 0;
  const auto read = [&]<class Input>(Input& input) {
    const ParameterName& names = Model::kParameters[k++];
    const char* name = names.also != nullptr && p.has(names.also) && !p.has(names.name) ? names.also : names.name;
    if constexpr (std::is_same_v<Input, SpectrumInput>)
      input = read_reflectance(p, name, std::move(input));
    else
      input = p.scalar_input(name, input, NumberRange{names.low, names.high});
  };
  auto inputs = Model::fields(model);
  static_assert(std::tuple_size_v<decltype(inputs)> == std::size(Model::kParameters));
  std::apply([&](auto&... input) { (read(input), ...); }, inputs);
  return model;
}

/// Calls f(Model{}) for every declarative material model.
template <class F, class... Models> void for_each_plain_model(const std::variant<Models...>&, F&& f) {
  const auto visit = [&]<class Model>(Model model) {
    if constexpr (DeclarativeBsdf<Model>) f(std::move(model));
  };
  (visit(Models{}), ...);
}

/// Reads the declarative model of this plugin; returns false if there is no such model.
bool read_plain_model(Properties& p, MaterialDescription& material) {
  bool found = false;
  for_each_plain_model(material.model, [&]<class Model>(const Model&) {
    if (p.type() != Model::kPlugin) return;
    Model model = read_plain<Model>(p);
    if constexpr (std::is_same_v<Model, PhongDescription>)
      limit_energy(p, model.diffuse_reflectance, model.specular_reflectance);
    material.model = std::move(model);
    found = true;
  });
  return found;
}

}  // namespace

std::vector<float> read_numbers(Properties& p, const char* name) {
  if (!p.is_string(name)) p.fail_at(name, "is invalid, expected a string of numbers");
  return parse_floats(*p.find_string(name), p.where(), name);
}

float read_ior(Properties& p, const char* property, float default_value) {
  if (!p.is_string(property)) return p.number(property, default_value, kPositive);
  const std::string name = *p.find_string(property);
  if (const std::optional<float> ior = find_ior(name)) return *ior;
  if (const Dispersion* dispersion = find_dispersion(name)) return catalogue_ior(*dispersion);
  std::vector<std::string> known = ior_names();
  const std::vector<std::string> dispersing = dispersion_names();
  known.insert(known.end(), dispersing.begin(), dispersing.end());
  p.fail_at(property,
            "is " + in_quotes(name) + ", expected a number or the name of a material" + did_you_mean(name, known));
}

ScalarInput read_alpha(Properties& p, const char* name, ScalarInput default_value) {
  ScalarInput alpha = p.scalar_input(name, default_value, kNotNegative);
  if (float* constant = std::get_if<float>(&alpha)) *constant = std::max(*constant, kMinAlpha);
  return alpha;
}

RoughnessDescription read_roughness(Properties& p) {
  RoughnessDescription result;
  const std::string distribution = p.string("distribution", "beckmann");
  if (distribution == "ggx") {
    result.distribution = RoughnessDescription::Distribution::kGgx;
  } else if (distribution == "phong" || distribution == "as") {
    // Their exponents are 2 / alpha^2 - 2, which makes them nearly Beckmann (Walter et al. 2007, section 5.2).
    p.context().note(p.where(), "distribution '" + distribution + "' rendered as 'beckmann'");
  } else if (distribution != "beckmann") {
    p.fail_at("distribution", "is " + in_quotes(distribution) + ", expected beckmann or ggx");
  }
  const bool along = p.has("alpha_u"), across = p.has("alpha_v");
  if (along != across) p.fail(std::string("has 'alpha_") + (along ? "u" : "v") + "' alone, expected both or 'alpha'");
  if (along && p.has("alpha")) p.fail_at("alpha", "is set together with 'alpha_u' and 'alpha_v', expected one of them");
  result.alpha_u = read_alpha(p, along ? "alpha_u" : "alpha", result.alpha_u);
  result.alpha_v = along ? read_alpha(p, "alpha_v", result.alpha_v) : result.alpha_u;
  p.ignore({"sample_visible"});
  return result;
}

RoughnessDescription read_uniform_roughness(Properties& p) {
  for (const char* name : {"alpha", "alpha_u", "alpha_v"})
    if (p.is_texture(name)) p.fail_at(name, "is a texture, expected a number");
  RoughnessDescription result = read_roughness(p);
  if (result.alpha_u != result.alpha_v) p.fail_at("alpha_v", "differs from 'alpha_u', expected equal values");
  return result;
}

const std::vector<std::string>& shared_bsdf_names() {
  static const std::vector<std::string> kNames = [] {
    std::vector<std::string> names = {"blendbsdf",
                                      "bumpmap",
                                      "coating",
                                      "conductor",
                                      "dielectric",
                                      "hair",
                                      "hk",
                                      "mask",
                                      "measured",
                                      "mixturebsdf",
                                      "normalmap",
                                      "null",
                                      "circular",
                                      "plastic",
                                      "polarizer",
                                      "pplastic",
                                      "retarder",
                                      "principled",
                                      "principledthin",
                                      "roughcoating",
                                      "roughconductor",
                                      "roughdielectric",
                                      "roughdiffuse",
                                      "roughplastic",
                                      "thindielectric",
                                      "twosided",
                                      "ward"};
    for_each_plain_model(MaterialDescription().model, [&](const auto& model) { names.emplace_back(model.kPlugin); });
    std::sort(names.begin(), names.end());
    return names;
  }();
  return kNames;
}

bool read_shared_bsdf(Properties& p, const BsdfDialect& dialect, MaterialDescription& material) {
  if (read_plain_model(p, material)) return true;
  const std::string& type = p.type();
  if (type == "conductor" || type == "roughconductor") {
    ConductorDescription conductor = read_conductor(p, dialect.before_version_2);
    if (type == "roughconductor") conductor.roughness = read_roughness(p);
    material.model = std::move(conductor);
  } else if (type == "dielectric" || type == "thindielectric" || type == "roughdielectric") {
    material.model = read_dielectric(p, dialect);
  } else if (type == "plastic" || type == "roughplastic" || type == "pplastic") {
    material.model = read_plastic(p);
    if (type == "pplastic") note_polarisation(p);
  } else if (type == "polarizer" || type == "circular" || type == "retarder") {
    material.model = read_polarizer(p);
    note_polarisation(p);
  } else if (type == "principled") {
    material.model = read_principled(p);
  } else if (type == "principledthin") {
    material.model = read_principled_thin(p);
  } else if (type == "roughdiffuse") {
    material.model = read_rough_diffuse(p);
  } else if (type == "ward") {
    material.model = read_ward(p);
  } else if (type == "hair") {
    material.model = read_hair(p);
  } else if (type == "hk") {
    material.model = read_hanrahan_krueger(p);
  } else if (type == "measured") {
    material.model = MeasuredDescription{p.file("filename")};
  } else if (type == "coating" || type == "roughcoating") {
    material.model = read_coat(p, dialect);
  } else if (type == "null") {
    material.model = NullDescription{};
  } else if (type == "twosided") {
    material.model = read_two_sided(p, dialect);
  } else if (type == "mask") {
    material.model = read_mask(p, dialect);
  } else if (type == "blendbsdf") {
    material.model = read_blend(p, dialect);
  } else if (type == "mixturebsdf") {
    material.model = read_mixture(p, dialect);
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
  p.reject_unused();
  material.where = p.where();
  if (const std::string* id = p.element().find_attribute("id")) material.id = *id;
  return add_material(p.context(), std::move(material));
}

}  // namespace sheaf
