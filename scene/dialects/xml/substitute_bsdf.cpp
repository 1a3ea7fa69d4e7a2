// Selection of the supported material that is most similar to an unsupported one.
#include "scene/dialects/xml/substitute_bsdf.h"

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

/// What a material that cannot be read offers for its replacement.
struct Substitutes {
  const XmlElement* nested = nullptr;  ///< its first nested material
  std::string plugin;                  ///< the most similar other plugin; may be empty
  DiffuseDescription diffuse;          ///< with its first readable color, or the default color
};

Substitutes substitutes_of(const XmlElement& bsdf, ReadContext& context) {
  Substitutes found;
  try {
    Properties p(bsdf, context);
    const std::vector<const XmlElement*> all = p.objects("bsdf");
    if (!all.empty()) found.nested = all[0];
    found.plugin = nearest_plugin(p);
    if (found.plugin == p.type()) found.plugin.clear();
    if (const char* name = p.first_color())
      found.diffuse.reflectance =
          p.spectrum_input(name, std::move(found.diffuse.reflectance), SpectrumRole::kReflectance);
  } catch (const SceneError&) {
    // The element is unreadable, or refers to itself
  }
  return found;
}

/// Replaces a material that cannot be read because of `error`.
MaterialId substitute(const XmlElement& bsdf, const SceneError& error, ReadContext& context,
                      const BsdfPluginReader& read) {
  const auto report = [&](const std::string& by) { context.errors.report(error.about("<bsdf>"), by); };
  MaterialDescription diffuse;
  diffuse.where = bsdf.where;
  if (context.errors.is_lenient()) {
    Substitutes known = substitutes_of(bsdf, context);
    if (known.nested != nullptr) {
      report("rendered as its nested material");
      return read_bsdf_or_substitute(*known.nested, context, read);
    }
    if (!known.plugin.empty()) try {
        const MaterialId id = read(bsdf, known.plugin.c_str());
        report(fmt::format("rendered as '{}'", known.plugin));
        return id;
      } catch (const SceneError&) {
        // Not similar enough
      }
    diffuse.model = std::move(known.diffuse);
  }
  report("rendered as a diffuse surface");
  return add_material(context, std::move(diffuse));
}

}  // namespace

MaterialId read_bsdf_or_substitute(const XmlElement& bsdf, ReadContext& context, const BsdfPluginReader& read) {
  try {
    return read(bsdf, nullptr);
  } catch (const SceneError& error) { return substitute(bsdf, error, context, read); }
}

}  // namespace sheaf
