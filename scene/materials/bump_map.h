// Bump maps.
#pragma once

#include "scene/materials/model.h"
#include "scene/materials/normal_options.h"

namespace sheaf {

/// Bump map: perturbs the shading normal as a displacement along the normal would.
struct BumpMapDescription {
  TextureId displacement{};
  float scale = 1;
  MaterialId nested{};
  NormalOptions options = {};

  using Closures = ClosureList<>;
  static BumpMapDescription read(Properties& p, const BsdfDialect& dialect);
  static constexpr Plugin<BumpMapDescription> kPlugins[] = {{"bumpmap", read}};
  static constexpr auto fields(auto& s) { return std::tie(s.displacement, s.scale, s.nested, s.options); }
  bool transmits(const NestedTransmission& of) const { return of(nested); }
  std::uint32_t flatten(MaterialFlattener& flattener, const MaterialWrappers& around,
                        const SourceLocation& where) const;
};

}  // namespace sheaf
