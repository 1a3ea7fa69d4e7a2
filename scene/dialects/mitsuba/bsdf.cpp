// The Mitsuba dialect: materials.
#include "scene/dialects/mitsuba/reader.h"
#include "scene/dialects/xml/read_phase.h"
#include "scene/dialects/xml/substitute_bsdf.h"
#include "scene/materials/plugins.h"

namespace sheaf::mitsuba {

namespace {

/// Reads `diffuse`, whose reflectance may be called `albedo` as in the Nori dialect.
MaterialModel read_diffuse(Properties& p, const BsdfDialect&) {
  DiffuseDescription diffuse;
  if (p.has("albedo"))
    diffuse.reflectance = read_reflectance(p, "albedo", diffuse.reflectance);
  else
    read_declared(p, diffuse);
  return diffuse;
}

/// Names that this dialect adds or changes. `mirror` is a name of the Nori dialect.
constexpr BsdfPlugin kPlugins[] = {
    {"diffuse", read_diffuse},
    {"mirror", [](Properties&, const BsdfDialect&) -> MaterialModel { return ConductorDescription{}; }},
};

MaterialId read_bsdf(const XmlElement& bsdf, const char* plugin, Reader& reader) {
  Properties p(bsdf, reader.context, plugin);
  const BsdfDialect dialect{.nested = [&](const XmlElement& nested) { return material_of(nested, reader); },
                            .phase = find_phase,
                            .before_version_2 = reader.before_version_2};
  return add_material_of(p, {read_bsdf_plugin(p, dialect, kPlugins), {}, {}});
}

}  // namespace

MaterialId material_of(const XmlElement& bsdf, Reader& reader) {
  if (auto it = reader.materials.find(&bsdf); it != reader.materials.end()) return it->second;
  const MaterialId id = read_bsdf_or_substitute(
      bsdf, reader.context,
      [&](const XmlElement& element, const char* plugin) { return read_bsdf(element, plugin, reader); });
  reader.materials.emplace(&bsdf, id);
  return id;
}

}  // namespace sheaf::mitsuba
