// Bump maps: reading, and the row of the map.
#include "scene/materials/bump_map.h"

#include "scene/materials/flattener.h"
#include "scene/materials/reading.h"

namespace sheaf {

namespace {

/// Reads the displacement of a bump map. In Mitsuba before version 2, an enclosing texture of type `scale` holds its
/// factor.
BumpMapDescription read_displacement(const XmlElement& texture, ReadContext& context) {
  const std::string* type = texture.find_attribute("type");
  if (type == nullptr || *type != "scale") return {read_map(texture, context), 1, {}};
  Properties p(texture, context);
  const float scale = p.number("scale", 1);
  BumpMapDescription result = read_displacement(only_texture(p), context);
  p.reject_unused();
  result.scale *= scale;
  return result;
}

}  // namespace

BumpMapDescription BumpMapDescription::read(Properties& p, const BsdfDialect& dialect) {
  const NormalOptions options = NormalOptions::read(p);
  const float scale = p.number("scale", 1);
  const MaterialId nested = read_nested_bsdf(p, dialect);
  BumpMapDescription result = read_displacement(only_texture(p), p.context());
  result.scale *= scale;
  result.nested = nested;
  result.options = options;
  return result;
}

std::uint32_t BumpMapDescription::flatten(MaterialFlattener& flattener, const MaterialWrappers& around,
                                          const SourceLocation& where) const {
  const std::uint32_t flags = NormalMapRow::kBump | options.flags();
  return flattener.flatten_mapped({static_cast<std::uint32_t>(displacement), flags, scale}, nested, around, where);
}

}  // namespace sheaf
