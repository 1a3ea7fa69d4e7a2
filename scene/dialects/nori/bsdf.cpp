// The Nori dialect: its own materials; all others are shared with Mitsuba.
#include "scene/dialects/common/add_material.h"
#include "scene/dialects/common/read_bsdf.h"
#include "scene/dialects/common/read_texture.h"
#include "scene/dialects/common/stand_in_bsdf.h"
#include "scene/dialects/nori/reader.h"

#include <algorithm>

namespace sheaf::nori {

namespace {

/// Reads a parameter in [0, 1] into `value`, if present.
void read_share(Properties& p, const char* name, ScalarInput& value) {
  value = p.scalar_input(name, value, kUnitInterval);
}

/// Returns the first of the alternative names that is present, or the first name.
const char* first_of(Properties& p, std::initializer_list<const char*> names) {
  for (const char* name : names)
    if (p.has(name)) return name;
  return *names.begin();
}

DiffuseDescription read_diffuse(Properties& p) {
  const DiffuseDescription default_value;
  p.ignore({"use_cosine"});  // selects the sampling strategy
  return {
      p.spectrum_input(first_of(p, {"albedo", "reflectance"}), default_value.reflectance, SpectrumRole::kReflectance)};
}

NoriMicrofacetDescription read_microfacet(Properties& p) {
  NoriMicrofacetDescription result;
  result.int_ior = read_ior(p, "intIOR", result.int_ior);
  result.ext_ior = read_ior(p, "extIOR", result.ext_ior);
  result.alpha = read_alpha(p, first_of(p, {"alpha", "m_alpha"}), result.alpha);
  result.kd = p.spectrum_input(first_of(p, {"kd", "albedo"}), result.kd, SpectrumRole::kReflectance);
  return result;
}

DisneyDescription read_disney(Properties& p) {
  DisneyDescription result;
  result.base_color =
      p.spectrum_input(first_of(p, {"baseColor", "albedo"}), result.base_color, SpectrumRole::kReflectance);
  read_share(p, "metallic", result.metallic);
  read_share(p, "subsurface", result.subsurface);
  read_share(p, "specular", result.specular);
  read_share(p, "specularTint", result.specular_tint);
  read_share(p, "roughness", result.roughness);
  read_share(p, "anisotropic", result.anisotropic);
  read_share(p, "sheen", result.sheen);
  read_share(p, "sheenTint", result.sheen_tint);
  read_share(p, "clearcoat", result.clearcoat);
  read_share(p, "clearcoatGloss", result.clearcoat_gloss);
  return result;
}

/// Reads `sigmaA`, the interior absorption coefficient of a boundary (Beer-Lambert law).
void read_absorption(Properties& p, std::optional<SpectrumDescription>& absorption) {
  if (p.type() != "dielectric" && p.type() != "roughdielectric" && p.type() != "null") return;
  const auto sigma_a = p.find_spectrum("sigmaA", SpectrumRole::kIor);
  if (!sigma_a) return;
  if (absorption) p.fail_at("sigmaA", "is set by two materials of one surface, expected one");
  absorption = *sigma_a;
}

/// Wraps `nested` in a normal map if the material has a `normal` texture.
MaterialId with_normal_map(Properties& p, MaterialId nested) {
  if (!p.is_texture("normal")) return nested;
  const std::optional<SpectrumInput> map = p.find_spectrum_input("normal", SpectrumRole::kIor);
  const TextureId texture = texture_showing(*map, p.where(), p.context());
  if (auto* bitmap =
          std::get_if<BitmapDescription>(&p.context().description.textures[static_cast<std::size_t>(texture)].model))
    bitmap->raw = true;
  MaterialDescription mapped;
  mapped.model = NormalMapDescription{texture, false, nested};
  mapped.where = p.where();
  return add_material(p.context(), std::move(mapped));
}

MaterialId read_plugin(const XmlElement& element, ReadContext& context,
                       std::optional<SpectrumDescription>& absorption) {
  Properties p(element, context);
  MaterialDescription material;
  const BsdfDialect dialect{[&](const XmlElement& nested) { return read_bsdf(nested, context, absorption); }, false,
                            true};
  if (p.type() == "diffuse") {
    material.model = read_diffuse(p);
  } else if (p.type() == "mirror") {
    material.model = ConductorDescription{};
  } else if (p.type() == "transparent") {
    material.model = NullDescription{};
  } else if (p.type() == "microfacet") {
    material.model = read_microfacet(p);
  } else if (p.type() == "disney") {
    material.model = read_disney(p);
  } else if (!read_shared_bsdf(p, dialect, material)) {
    std::vector<std::string> known = shared_bsdf_names();
    known.insert(known.end(), {"disney", "microfacet", "mirror", "transparent"});
    std::sort(known.begin(), known.end());
    p.fail_plugin(known);
  }
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
  return read_bsdf_leniently(element, context,
                             [&](const XmlElement& e) { return read_plugin(e, context, absorption); });
}

}  // namespace sheaf::nori
