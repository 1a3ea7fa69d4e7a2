// The Mitsuba dialect: materials.
#include "scene/mitsuba.h"

#include <algorithm>

namespace sheaf::mitsuba {

namespace {

struct NamedIor {
  const char* name;
  float ior;
};
/// Indices of refraction at 589 nm that a scene may ask for by name; the set and values that Mitsuba documents.
constexpr NamedIor kNamedIors[] = {
    {"vacuum", 1.0f},      {"helium", 1.000036f},        {"hydrogen", 1.000132f},
    {"air", 1.000277f},    {"carbon dioxide", 1.00045f}, {"water", 1.333f},
    {"acetone", 1.36f},    {"ethanol", 1.361f},          {"carbon tetrachloride", 1.461f},
    {"glycerol", 1.4729f}, {"benzene", 1.501f},          {"silicone oil", 1.52045f},
    {"bromine", 1.661f},   {"water ice", 1.31f},         {"fused quartz", 1.458f},
    {"pyrex", 1.47f},      {"acrylic glass", 1.49f},     {"polypropylene", 1.49f},
    {"bk7", 1.5046f},      {"sodium chloride", 1.544f},  {"amber", 1.55f},
    {"pet", 1.575f},       {"diamond", 2.419f}};

const SpectrumDescription kOne = SpectrumDescription::constant(1);

/// An index of refraction, given as a number or as the name of a material.
float read_ior(Properties& p, const char* property, float otherwise) {
  if (!p.is_string(property)) return p.number(property, otherwise, kPositive);
  const std::string name = *p.find_string(property);
  std::vector<std::string> known;
  for (const NamedIor& entry : kNamedIors) {
    if (name == entry.name) return entry.ior;
    known.emplace_back(entry.name);
  }
  p.fail_at(property,
            "is " + in_quotes(name) + ", expected a number or the name of a material" + did_you_mean(name, known));
}

DielectricDescription read_dielectric(Properties& p) {
  DielectricDescription result;
  result.int_ior = read_ior(p, "int_ior", result.int_ior);
  result.ext_ior = read_ior(p, "ext_ior", result.ext_ior);
  result.specular_reflectance = p.spectrum("specular_reflectance", kOne, SpectrumRole::kReflectance);
  result.specular_transmittance = p.spectrum("specular_transmittance", kOne, SpectrumRole::kReflectance);
  return result;
}

ConductorDescription read_conductor(Properties& p, bool before_version_2) {
  ConductorDescription result;
  result.specular_reflectance = p.spectrum("specular_reflectance", kOne, SpectrumRole::kReflectance);
  const auto eta = p.find_spectrum("eta", SpectrumRole::kIor), k = p.find_spectrum("k", SpectrumRole::kIor);
  const std::optional<std::string> material = p.find_string("material");
  if (eta || k) {
    if (!eta || !k) p.fail(std::string("has '") + (eta ? "eta" : "k") + "' alone, expected both 'eta' and 'k'");
    if (material) p.fail_at("material", "is given beside 'eta' and 'k', expected one or the other");
    result.ior = {*eta, *k};
  } else if (material && *material != "none") {
    p.fail_at("material", "is " + in_quotes(*material) +
                              ": metals by name are not known, give 'eta' and 'k' as spectra ('none' is a mirror)");
  } else if (!material && before_version_2) {
    p.fail(
        "is copper by default in this version of the format: give 'eta' and 'k' as spectra, or material 'none' "
        "for a mirror");
  }
  return result;
}

/// A side of a two-sided material: the side of the child that its normal shows.
MaterialId front_of(MaterialId id, const Properties& p) {
  const MaterialDescription& child = p.context().description.materials[static_cast<std::size_t>(id)];
  if (std::holds_alternative<DielectricDescription>(child.model))
    p.fail("holds a material that transmits light (line " + std::to_string(child.where.line) + ")");
  if (const auto* both = std::get_if<TwoSidedDescription>(&child.model)) return both->front;
  return id;
}

TwoSidedDescription read_two_sided(Properties& p, Reader& reader) {
  const std::vector<const XmlElement*> children = p.objects("bsdf");
  if (children.empty() || children.size() > 2)
    p.fail("holds " + std::to_string(children.size()) + " nested <bsdf>, expected one or two");
  const MaterialId front = front_of(material_of(*children[0], reader), p);
  return {front, children.size() == 2 ? front_of(material_of(*children[1], reader), p) : front};
}

}  // namespace

MaterialId material_of(const XmlElement& bsdf, Reader& reader) {
  if (auto it = reader.materials.find(&bsdf); it != reader.materials.end()) return it->second;
  Properties p(bsdf, reader.context);
  MaterialDescription material;
  material.where = bsdf.where;
  if (const std::string* id = bsdf.find_attribute("id")) material.id = *id;
  if (p.type() == "diffuse") {
    material.model =
        DiffuseDescription{p.spectrum("reflectance", SpectrumDescription::constant(0.5f), SpectrumRole::kReflectance)};
  } else if (p.type() == "conductor") {
    material.model = read_conductor(p, reader.before_version_2);
  } else if (p.type() == "dielectric") {
    material.model = read_dielectric(p);
  } else if (p.type() == "twosided") {
    material.model = read_two_sided(p, reader);
  } else {
    p.fail_plugin({"conductor", "dielectric", "diffuse", "twosided"});
  }
  p.finish();
  const MaterialId id = add_material(reader.context, std::move(material));
  reader.materials.emplace(&bsdf, id);
  return id;
}

}  // namespace sheaf::mitsuba
