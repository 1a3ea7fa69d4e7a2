// Discrete distributions: alias tables, which sample an entry with one load.
#pragma once

#include "core/math/vec.h"
#include "core/soa/lane_array.h"

#include <span>
#include <vector>

namespace sheaf {

/// One row of an alias table; 16 bytes so that a row is one load.
struct AliasEntry {
  float threshold;      ///< probability in [0, 1] that this row selects its own entry, not its alias
  std::uint32_t alias;  ///< index of the alias, relative to the start of its part of the table
  float pdf;            ///< probability of this entry
  float alias_pdf;      ///< probability of the alias
};
static_assert(sizeof(AliasEntry) == 16);

/// Builds an alias table with one row per weight (Vose, "A Linear Algorithm for Generating Random Numbers with a Given
/// Distribution", 1991). Throws SceneError unless all weights are finite and non-negative and their sum is positive.
/// Probabilities are normalized in double precision.
std::vector<AliasEntry> build_alias_table(std::span<const float> weights);

/// An entry sampled from an alias table.
template <class L> struct AliasSample {
  typename L::Uint index;      ///< index of the entry, relative to the start of its part of the table
  typename L::Float pdf;       ///< its probability
  typename L::Float remapped;  ///< a new uniform number in [0, 1) from the unused part of u
};

/// Samples rows [offset, offset + count) of `table` with u in [0, 1). Each lane may use another part of the table.
/// Entries of weight zero are never sampled. `remapped` keeps about 24 - log2(count) random bits.
template <class L>
SHEAF_INLINE AliasSample<L> sample_alias(const AliasEntry* table, typename L::Uint offset, typename L::Uint count,
                                         typename L::Float u) {
  using F = typename L::Float;
  using U = typename L::Uint;
  const F scale = to_float(count);
  const U row = min(to_uint(u * scale), count - U(1u));
  const F rest = clamp(fma(u, scale, -to_float(row)), F(0.0f), F(kOneMinusEpsilon));

  F words[4];
  RowPointers<L>(table, offset + row).read_four(words);

  const F threshold = words[0];
  const auto itself = rest < threshold;
  const F begin = select(itself, F(0.0f), threshold);
  const F length = select(itself, threshold, F(1.0f) - threshold);
  return {select(itself, row, float_bits(words[1])), select(itself, words[2], words[3]),
          min((rest - begin) / length, F(kOneMinusEpsilon))};
}

}  // namespace sheaf
