#include "scene/materials/reading.h"

#include "scene/data/glasses.h"
#include "scene/data/named_ior.h"
#include "scene/description/scaled_spectrum.h"
#include "scene/textures/constant_map.h"
#include "scene/xml/xml_values.h"

#include <algorithm>

namespace sheaf {

namespace {

constexpr float kMinAlpha = 1e-4f;

/// Maximum of a spectrum per channel in linear Rec.709. For a table, returns its maximum value in all three channels.
Vec3f brightest(const SpectrumDescription& spectrum) {
  using S = SpectrumDescription;
  if (const auto* constant = std::get_if<S::Constant>(&spectrum.value))
    return {constant->value, constant->value, constant->value};
  if (const auto* rgb = std::get_if<S::Rgb>(&spectrum.value)) return rgb->value;
  float largest = 0;
  if (const auto* table = std::get_if<S::Table>(&spectrum.value))
    for (const float v : table->values) largest = std::max(largest, v);
  return {largest, largest, largest};
}

}  // namespace

MaterialId add_material(ReadContext& context, MaterialDescription material) {
  context.material_list.push_back(std::move(material));
  return static_cast<MaterialId>(context.material_list.size() - 1);
}

MaterialId add_material_of(Properties& p, MaterialDescription material) {
  p.reject_unused();
  material.where = p.where();
  if (const std::string* id = p.element().find_attribute("id")) material.id = *id;
  return add_material(p.context(), std::move(material));
}

MaterialId add_black_material(Properties& p) {
  MaterialDescription black;
  black.model = DiffuseDescription{SpectrumDescription::constant(0)};
  black.where = p.where();
  return add_material(p.context(), std::move(black));
}

float read_ior(Properties& p, const char* property, float default_value) {
  if (!p.is_string(property)) return p.number(property, default_value, kPositive);
  const std::optional<std::string> given = p.find_string(property);
  if (!given) return default_value;
  const std::string& name = *given;
  if (const std::optional<float> ior = find_ior(name)) return *ior;
  if (const Dispersion* dispersion = find_dispersion(name)) return catalog_ior(*dispersion);
  std::vector<std::string> known = ior_names();
  const std::vector<std::string> dispersing = dispersion_names();
  known.insert(known.end(), dispersing.begin(), dispersing.end());
  p.report_at(
      property,
      fmt::format("is {}, expected a number or the name of a material{}", in_quotes(name), did_you_mean(name, known)),
      SceneErrorCode::kUnknownName);
  return default_value;
}

SpectrumInput read_reflectance(Properties& p, const char* name, SpectrumInput default_value) {
  return p.spectrum_input(name, std::move(default_value), SpectrumRole::kReflectance);
}

void read_unit(Properties& p, const char* name, ScalarInput& value) {
  value = p.scalar_input(name, value, kUnitInterval);
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
    p.context().note(p.where(), fmt::format("distribution '{}' rendered as 'beckmann'", distribution));
  } else if (distribution != "beckmann") {
    p.report_at("distribution", fmt::format("is {}, expected beckmann or ggx", in_quotes(distribution)),
                SceneErrorCode::kUnknownName);
  }
  const bool along = p.has("alpha_u"), across = p.has("alpha_v");
  if (along != across)
    p.fail(fmt::format("has only 'alpha_{}', expected both 'alpha_u' and 'alpha_v', or 'alpha'", along ? "u" : "v"));
  if (along && p.has("alpha")) p.report_conflict("alpha", "'alpha_u' and 'alpha_v'");
  result.alpha_u = read_alpha(p, along ? "alpha_u" : "alpha", result.alpha_u);
  result.alpha_v = along ? read_alpha(p, "alpha_v", result.alpha_v) : result.alpha_u;
  p.ignore({"sample_visible"});
  return result;
}

RoughnessDescription read_uniform_roughness(Properties& p) {
  for (const char* name : {"alpha", "alpha_u", "alpha_v"})
    if (p.is_texture(name)) p.report_at(name, "is a texture, expected a number", SceneErrorCode::kWrongType);
  RoughnessDescription result = read_roughness(p);
  if (result.alpha_u != result.alpha_v) {
    p.report_at("alpha_v", "differs from 'alpha_u', expected equal values");
    result.alpha_v = result.alpha_u;
  }
  return result;
}

void limit_energy(Properties& p, SpectrumInput& diffuse, SpectrumInput& specular) {
  if (!p.boolean("ensure_energy_conservation", true)) return;
  auto* d = std::get_if<SpectrumDescription>(&diffuse);
  auto* s = std::get_if<SpectrumDescription>(&specular);
  if (d == nullptr || s == nullptr) return;
  const Vec3f sum = brightest(*d) + brightest(*s);
  const float largest = std::max({sum.x, sum.y, sum.z});
  if (!(largest > 1.0f)) return;
  constexpr float kMax = 0.99f;
  *d = scaled(std::move(*d), kMax / largest);
  *s = scaled(std::move(*s), kMax / largest);
  p.context().note(
      p.where(),
      fmt::format("reflects up to {} of the light; its reflectances are scaled down so that they add up to 0.99",
                  largest));
}

std::vector<float> read_numbers(Properties& p, const char* name) {
  if (!p.is_string(name)) p.fail_at(name, "is invalid, expected a string of numbers", SceneErrorCode::kWrongType);
  return parse_floats(p.required_string(name), p.where(), name);
}

const char* first_of(Properties& p, std::initializer_list<const char*> names) {
  for (const char* name : names)
    if (p.has(name)) return name;
  return *names.begin();
}

std::string list_of(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  return list;
}

std::vector<const XmlElement*> nested_bsdfs(Properties& p, std::size_t low, std::size_t high, const char* expected) {
  std::vector<const XmlElement*> found = p.objects("bsdf");
  if (found.size() < low || found.size() > high)
    p.fail(fmt::format("has {} nested <bsdf>, expected {}", found.size(), expected), SceneErrorCode::kMissing);
  return found;
}

MaterialId read_nested_bsdf(Properties& p, const BsdfDialect& dialect) {
  return dialect.nested(*nested_bsdfs(p, 1, 1, "one")[0]);
}

void expect_opaque(Properties& p, MaterialId nested) {
  const std::vector<MaterialDescription>& materials = p.context().material_list;
  if (transmits(materials, nested))
    p.fail(fmt::format("has a nested material that transmits light (line {})",
                       materials[static_cast<std::size_t>(nested)].where.line));
}

const XmlElement& only_texture(Properties& p) {
  const XmlElement* texture = p.any_texture_or_color();
  if (texture == nullptr) p.fail("has no <texture>, expected one", SceneErrorCode::kMissing);
  return *texture;
}

TextureId read_map(const XmlElement& texture, ReadContext& context) {
  return texture_showing(context.readers.texture(texture, context), texture.where, context);
}

void note_polarization(Properties& p) {
  p.context().note(p.where(), fmt::format("bsdf '{}' rendered without polarization, which is not simulated", p.type()));
}

}  // namespace sheaf
