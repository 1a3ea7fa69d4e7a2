// Selection of the supported material that is most similar to an unsupported one.
#include "scene/dialects/xml/stand_in_bsdf.h"

#include "scene/materials/reading.h"

#include <algorithm>
#include <cctype>

namespace sheaf {

namespace {

std::string lower_case(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

bool has_any(Properties& p, std::initializer_list<const char*> names) {
  return std::any_of(names.begin(), names.end(), [&](const char* name) { return p.has(name); });
}

/// Part of a plugin name, and the known plugins it suggests, smooth and rough.
struct NamePart {
  const char* part;
  const char* smooth;
  const char* rough;
};
constexpr NamePart kNameParts[] = {
    {"glass", "dielectric", "roughdielectric"},
    {"dielectric", "dielectric", "roughdielectric"},
    {"water", "dielectric", "roughdielectric"},
    {"mirror", "conductor", "roughconductor"},
    {"conductor", "conductor", "roughconductor"},
    {"metal", "conductor", "roughconductor"},
    {"plastic", "plastic", "roughplastic"},
    {"glossy", "roughplastic", "roughplastic"},
    {"disney", "principled", "principled"},
    {"principled", "principled", "principled"},
    {"uber", "principled", "principled"},
    {"pbr", "principled", "principled"},
    {"null", "null", "null"},
    {"transparent", "null", "null"},
    {"invisible", "null", "null"},
};

/// Returns the known plugin that is most similar to an unknown one, or an empty string.
std::string nearest_plugin(Properties& p) {
  const std::string name = lower_case(p.type());
  const bool rough = name.find("rough") != std::string::npos || has_any(p, {"alpha", "alpha_u", "roughness"});
  for (const NamePart& known : kNameParts)
    if (name.find(known.part) != std::string::npos) return rough ? known.rough : known.smooth;
  if (has_any(p, {"base_color", "metallic"})) return "principled";
  if (p.has("eta") && p.has("k")) return rough ? "roughconductor" : "conductor";
  if (p.has("diffuse_reflectance")) return rough ? "roughplastic" : "plastic";
  if (has_any(p, {"int_ior", "specular_transmittance"})) return rough ? "roughdielectric" : "dielectric";
  return {};
}

/// Adds a diffuse material with the object's first readable colour, or the default colour.
MaterialId add_diffuse(const XmlElement& bsdf, ReadContext& context) {
  MaterialDescription material;
  read_what_can_be(bsdf, context, [&] {
    DiffuseDescription diffuse;
    Properties p(bsdf, context);
    if (const char* name = p.first_color())
      diffuse.reflectance = p.spectrum_input(name, diffuse.reflectance, SpectrumRole::kReflectance);
    material.model = std::move(diffuse);
  });
  material.where = bsdf.where;
  return add_material(context, std::move(material));
}

/// Returns the first nested material, or null.
const XmlElement* held_material(const XmlElement& bsdf, ReadContext& context) {
  const XmlElement* held = nullptr;
  read_what_can_be(bsdf, context, [&] {
    Properties p(bsdf, context);
    const std::vector<const XmlElement*> all = p.objects("bsdf");
    held = all.empty() ? nullptr : all[0];
  });
  return held;
}

}  // namespace

MaterialId read_bsdf_leniently(const XmlElement& bsdf, ReadContext& context,
                               const std::function<MaterialId(const XmlElement&)>& read) {
  MaterialId id{};
  const auto error = read_what_can_be(bsdf, context, [&] { id = read(bsdf); });
  if (!error) return id;
  const auto say = [&](const std::string& what) { context.description.stand_ins.push_back(*error + what); };
  // Try the nested material, then a similar plugin, then a diffuse surface
  if (const XmlElement* held = held_material(bsdf, context)) {
    say(" (rendered as its nested material)");
    return read_bsdf_leniently(*held, context, read);
  }
  std::string nearest;
  read_what_can_be(bsdf, context, [&] {
    Properties p(bsdf, context);
    nearest = nearest_plugin(p);
  });
  if (!nearest.empty() && context.types.emplace(&bsdf, nearest).second &&
      !read_what_can_be(bsdf, context, [&] { id = read(bsdf); })) {
    say(" (rendered as '" + nearest + "')");
    return id;
  }
  say(" (rendered as a diffuse surface)");
  return add_diffuse(bsdf, context);
}

}  // namespace sheaf
