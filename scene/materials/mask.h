// Opacity masks, and polarizing filters with their effect on unpolarized light.
#pragma once

#include "scene/materials/model.h"

namespace sheaf {

/// Opacity mask: `nested` with weight `opacity`; the rest of the light passes unchanged.
struct MaskDescription {
  ScalarInput opacity = 0.5f;
  MaterialId nested{};

  using Closures = ClosureList<>;
  static MaskDescription read(Properties& p, const BsdfDialect& dialect);
  static MaskDescription read_polarizer(Properties& p, const BsdfDialect& dialect);
  static MaskDescription read_retarder(Properties& p, const BsdfDialect& dialect);
  static constexpr Plugin<MaskDescription> kPlugins[] = {
      {"mask", read}, {"polarizer", read_polarizer}, {"circular", read_polarizer}, {"retarder", read_retarder}};
  static constexpr auto fields(auto& s) { return std::tie(s.opacity, s.nested); }
  bool transmits() const { return true; }
  std::uint32_t flatten(MaterialFlattener& flattener, const MaterialWrappers& around,
                        const SourceLocation& where) const;
};

}  // namespace sheaf
