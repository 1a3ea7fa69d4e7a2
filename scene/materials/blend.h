// Blends of two materials, and mixtures of many as trees of blends.
#pragma once

#include "scene/materials/model.h"

namespace sheaf {

/// (1 - weight) nested[0] + weight nested[1].
struct BlendDescription {
  ScalarInput weight = 0.5f;
  MaterialId nested[2]{};

  using Closures = ClosureList<>;
  static BlendDescription read(Properties& p, const BsdfDialect& dialect);
  /// Reads nested blends; a black material takes the remaining weight.
  static BlendDescription read_mixture(Properties& p, const BsdfDialect& dialect);
  static constexpr Plugin<BlendDescription> kPlugins[] = {{"blendbsdf", read}, {"mixturebsdf", read_mixture}};
  static constexpr auto fields(auto& s) { return std::tie(s.weight, s.nested[0], s.nested[1]); }
  bool transmits(const NestedTransmission& of) const { return of(nested[0]) || of(nested[1]); }
  std::uint32_t flatten(MaterialFlattener& flattener, const MaterialWrappers& around,
                        const SourceLocation& where) const;
};

}  // namespace sheaf
