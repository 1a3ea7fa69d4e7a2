// Normal maps: reading, and the row of the map.
#include "scene/materials/normal_map.h"

#include "scene/materials/flattener.h"
#include "scene/materials/reading.h"

#include <cmath>

namespace sheaf {

NormalMapDescription NormalMapDescription::read(Properties& p, const BsdfDialect& dialect) {
  const NormalOptions options = NormalOptions::read(p);
  const bool flip_green = p.boolean("flip_green", false);
  const MaterialId nested = read_nested_bsdf(p, dialect);
  return {read_map(only_texture(p), p.context()), flip_green, nested, options, 1, false};
}

std::uint32_t NormalMapDescription::flatten(MaterialFlattener& flattener, const MaterialWrappers& around,
                                            const SourceLocation& where) const {
  if (!std::isfinite(scale)) throw SceneError(where, "the scale of a normal map is not finite");
  const std::uint32_t flags =
      (flip_green ? NormalMapRow::kFlipGreen : 0u) | (follows_uv ? NormalMapRow::kFollowsUv : 0u) | options.flags();
  return flattener.flatten_mapped({static_cast<std::uint32_t>(normals), flags, scale}, nested, around, where);
}

}  // namespace sheaf
