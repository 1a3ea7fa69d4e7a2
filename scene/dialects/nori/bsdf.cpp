// The Nori dialect: its own materials; all others are shared with Mitsuba.
#include "scene/dialects/nori/reader.h"
#include "scene/dialects/xml/read_phase.h"
#include "scene/dialects/xml/read_texture.h"
#include "scene/dialects/xml/substitute_bsdf.h"
#include "scene/materials/plugins.h"

namespace sheaf::nori {

namespace {

MaterialModel read_diffuse(Properties& p, const BsdfDialect&) {
  p.ignore({"use_cosine"});  // selects the sampling strategy
  DiffuseDescription diffuse;
  diffuse.reflectance = read_reflectance(p, first_of(p, {"albedo", "reflectance"}), diffuse.reflectance);
  return diffuse;
}

template <class Model> MaterialModel read_own(Properties& p, const BsdfDialect& dialect) {
  return read_model<Model>(p, SpectrumRole::kReflectance, dialect);
}

/// Names that this dialect adds or changes.
constexpr BsdfPlugin kPlugins[] = {
    {"diffuse", read_diffuse},
    {"disney", read_own<DisneyDescription>},
    {"microfacet", read_own<NoriMicrofacetDescription>},
    {"mirror", [](Properties&, const BsdfDialect&) -> MaterialModel { return ConductorDescription{}; }},
    {"transparent", [](Properties&, const BsdfDialect&) -> MaterialModel { return NullDescription{}; }},
};

/// Reads `sigmaA`, the interior absorption coefficient of a boundary (Beer-Lambert law).
void read_absorption(Properties& p, std::optional<SpectrumDescription>& absorption) {
  if (p.type() != "dielectric" && p.type() != "roughdielectric" && p.type() != "null") return;
  const auto sigma_a = p.find_spectrum("sigmaA", SpectrumRole::kIor);
  if (!sigma_a) return;
  if (absorption)
    p.report_at("sigmaA", "is set by two materials of one surface, expected one", SceneErrorCode::kDuplicate);
  else
    absorption = *sigma_a;
}

/// Wraps `nested` in a normal map if the material has a `normal` texture.
MaterialId with_normal_map(Properties& p, MaterialId nested) {
  if (!p.is_texture("normal")) return nested;
  const std::optional<SpectrumInput> map = p.find_spectrum_input("normal", SpectrumRole::kIor);
  if (!map) return nested;
  const TextureId texture = texture_showing(*map, p.where(), p.context());
  if (auto* bitmap =
          std::get_if<BitmapDescription>(&p.context().description.textures[static_cast<std::size_t>(texture)].model))
    bitmap->raw = true;
  MaterialDescription mapped;
  mapped.model = NormalMapDescription{texture, false, nested};
  mapped.where = p.where();
  return add_material(p.context(), std::move(mapped));
}

MaterialId read_plugin(const XmlElement& element, const char* plugin, ReadContext& context,
                       std::optional<SpectrumDescription>& absorption) {
  Properties p(element, context, plugin);
  const BsdfDialect dialect{.nested = [&](const XmlElement& nested) { return read_bsdf(nested, context, absorption); },
                            .phase = find_phase,
                            .names_disperse = true};
  MaterialDescription material{read_bsdf_plugin(p, dialect, kPlugins), {}, {}};
  read_absorption(p, absorption);
  const bool mapped = p.has("normal");
  if (!mapped) return add_material_of(p, std::move(material));
  material.where = element.where;
  const MaterialId id = with_normal_map(p, add_material(context, std::move(material)));
  p.reject_unused();
  return id;
}

}  // namespace

MaterialId read_bsdf(const XmlElement& element, ReadContext& context, std::optional<SpectrumDescription>& absorption) {
  return read_bsdf_or_substitute(element, context, [&](const XmlElement& e, const char* plugin) {
    return read_plugin(e, plugin, context, absorption);
  });
}

}  // namespace sheaf::nori
