// Materials for the two sides of a surface.
#pragma once

#include "scene/materials/model.h"

namespace sheaf {

/// `front` on the side of the normal and `back` on the other. Neither may transmit.
struct TwoSidedDescription {
  MaterialId front{}, back{};

  using Closures = ClosureList<>;
  static TwoSidedDescription read(Properties& p, const BsdfDialect& dialect);
  static constexpr Plugin<TwoSidedDescription> kPlugins[] = {{"twosided", read}};
  static constexpr auto fields(auto& s) { return std::tie(s.front, s.back); }
  bool transmits() const { return false; }
  std::uint32_t flatten(MaterialFlattener& flattener, const MaterialWrappers& around,
                        const SourceLocation& where) const;
};

}  // namespace sheaf
