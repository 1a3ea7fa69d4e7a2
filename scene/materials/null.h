// A null interface.
#pragma once

#include "scene/materials/model.h"

namespace sheaf {

/// A null interface: light passes unchanged.
struct NullDescription {
  using Closures = ClosureList<>;
  static NullDescription read(Properties& p, const BsdfDialect& dialect);
  static constexpr Plugin<NullDescription> kPlugins[] = {{"null", read}};
  static constexpr auto fields(auto&) { return std::tie(); }
  bool transmits() const { return true; }
  std::uint32_t flatten(MaterialFlattener& flattener, const MaterialWrappers& around,
                        const SourceLocation& where) const;
};

}  // namespace sheaf
