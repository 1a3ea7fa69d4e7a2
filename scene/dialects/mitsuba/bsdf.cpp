// The Mitsuba dialect: materials.
#include "scene/dialects/common/read_bsdf.h"
#include "scene/dialects/common/stand_in_bsdf.h"
#include "scene/dialects/mitsuba/reader.h"

namespace sheaf::mitsuba {

namespace {

MaterialId read_bsdf(const XmlElement& bsdf, Reader& reader) {
  Properties p(bsdf, reader.context);
  const BsdfDialect dialect{[&](const XmlElement& nested) { return material_of(nested, reader); },
                            reader.before_version_2};
  MaterialDescription material;
  if (p.type() == "mirror") {
    material.model = ConductorDescription{};  // name of the Nori dialect
  } else if (p.type() == "diffuse" && p.has("albedo")) {
    material.model = DiffuseDescription{p.spectrum_input("albedo", {}, SpectrumRole::kReflectance)};
  } else if (!read_shared_bsdf(p, dialect, material)) {
    p.fail_plugin(shared_bsdf_names());
  }
  return add_material_of(p, std::move(material));
}

}  // namespace

MaterialId material_of(const XmlElement& bsdf, Reader& reader) {
  if (auto it = reader.materials.find(&bsdf); it != reader.materials.end()) return it->second;
  const MaterialId id =
      read_bsdf_leniently(bsdf, reader.context, [&](const XmlElement& element) { return read_bsdf(element, reader); });
  reader.materials.emplace(&bsdf, id);
  return id;
}

}  // namespace sheaf::mitsuba
