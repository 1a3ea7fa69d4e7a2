// The Mitsuba dialect: materials.
#include "scene/dialects/mitsuba.h"
#include "scene/dialects/read_bsdf.h"

namespace sheaf::mitsuba {

MaterialId material_of(const XmlElement& bsdf, Reader& reader) {
  if (auto it = reader.materials.find(&bsdf); it != reader.materials.end()) return it->second;
  Properties p(bsdf, reader.context);
  const BsdfDialect dialect{[&](const XmlElement& nested) { return material_of(nested, reader); },
                            reader.before_version_2};
  MaterialDescription material;
  if (!read_shared_bsdf(p, dialect, material)) p.fail_plugin(shared_bsdf_names());
  const MaterialId id = add_material_of(p, std::move(material));
  reader.materials.emplace(&bsdf, id);
  return id;
}

}  // namespace sheaf::mitsuba
