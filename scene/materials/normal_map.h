// Normal maps.
#pragma once

#include "scene/materials/model.h"
#include "scene/materials/normal_options.h"

namespace sheaf {

/// Normal map: reads the shading normal from a texture, in the frame of the surface's tangent.
struct NormalMapDescription {
  TextureId normals{};      ///< (r, g, b) = (n + 1) / 2
  bool flip_green = false;  ///< DirectX convention: green points down
  MaterialId nested{};
  NormalOptions options = {};
  float scale = 1;  ///< factor of the normal's x and y before it is normalized
  /// The map's y axis follows the direction of increasing v even where uv are mirrored. Otherwise it is the cross
  /// product of the normal and the tangent.
  bool follows_uv = false;

  using Closures = ClosureList<>;
  static NormalMapDescription read(Properties& p, const BsdfDialect& dialect);
  static constexpr Plugin<NormalMapDescription> kPlugins[] = {{"normalmap", read}};
  static constexpr auto fields(auto& s) {
    return std::tie(s.normals, s.flip_green, s.nested, s.options, s.scale, s.follows_uv);
  }
  bool transmits(const NestedTransmission& of) const { return of(nested); }
  std::uint32_t flatten(MaterialFlattener& flattener, const MaterialWrappers& around,
                        const SourceLocation& where) const;
};

}  // namespace sheaf
