// Discrete distributions as tables of quantiles. Sampling reads one row without a search and preserves stratification.
//
// All rows have the same probability. A row is a part of a likely entry, or a run of less likely entries that share it
// equally. Runs deviate from the proportions of the weights, and are chosen to deviate least where that would cost
// variance. Probabilities are those with which entries are actually sampled.
#pragma once

#include "core/simd/lanes.h"

#include <span>
#include <vector>

namespace sheaf {

/// A row of the table, with the probability 1 / kQuantiles: a run of entries of equal probability, or one of the equal
/// parts of a likely entry. Bits: 17 for the first entry, 1 that is set for a run, 14 for the length of the run or the
/// number of the part.
struct Quantile {
  std::uint32_t bits;

  static Quantile of_run(std::uint32_t first, std::uint32_t length) { return {first << 15 | 1u << 14 | length}; }
  static Quantile of_part(std::uint32_t entry, std::uint32_t number) { return {entry << 15 | number}; }
  std::uint32_t first() const { return bits >> 15; }
  /// Number of entries of the run; 1 for a part.
  std::uint32_t length() const { return (bits >> 14 & 1u) != 0 ? bits & 0x3fffu : 1u; }
};

/// Number of rows of a table.
inline constexpr std::uint32_t kQuantiles = 1024;
/// Maximum number of entries of a quantile. More would leave too few random bits for each.
inline constexpr std::uint32_t kMaxQuantileRun = 256;
/// Maximum number of entries of a distribution: runs of maximum length and gaps between them then use all quantiles.
inline constexpr std::uint32_t kMaxQuantileEntries = kQuantiles * kMaxQuantileRun / 2;

/// Fills the kQuantiles rows at `table` for at most kMaxQuantileEntries `weights`, which are finite and not negative.
/// Replaces the weights by the probabilities with which draw_quantile() selects the entries. They are positive wherever
/// weights are, and sometimes for entries of weight 0 in between. Returns false, and changes nothing, if no weight is
/// positive.
bool build_quantiles(std::span<double> weights, Quantile* table);

/// An entry sampled from a table of quantiles.
template <class L> struct QuantileDraw {
  typename L::Uint index, quantile;
  /// Position within the entry. In a run it is in [0, 1), and 1 is subtracted, so the sign tells the two cases apart.
  /// Otherwise it is in [0, number of the entry's quantiles).
  typename L::Float position;

  /// A new uniform number in [0, 1) from the unused part of u. `probability`: that of the entry.
  SHEAF_INLINE Float<L> remapped(Float<L> probability) const {
    using F = Float<L>;
    const auto in_run = position < F(0.0f);
    const F parts = select(in_run, F(1.0f), probability * F(static_cast<float>(kQuantiles)));
    return min(select(in_run, position + F(1.0f), position) / parts, F(kOneMinusEpsilon));
  }
};

/// Samples the table that begins at row tables[table], one for each lane, with u in [0, 1). The index is monotonic in
/// u, and so is remapped() within an entry. remapped() keeps about 24 - log2(1 / probability) random bits.
template <class L>
SHEAF_INLINE QuantileDraw<L> draw_quantile(const Quantile* tables, typename L::Uint table, typename L::Float u) {
  using F = typename L::Float;
  using U = typename L::Uint;
  const F scaled = u * F(static_cast<float>(kQuantiles));
  const U row = to_uint(scaled), bits = gather(reinterpret_cast<const std::uint32_t*>(tables), table + row);
  const F rest = scaled - to_float(row), number = to_float(bits & U(0x3fffu));
  const auto is_run = (bits & U(1u << 14)) != U(0u);
  const F in_run = min(rest * number, number - F(0x1p-8f));
  const U step = select(is_run, to_uint(in_run), U(0u));
  return {(bits >> 15) + step, row, select(is_run, in_run - to_float(step) - F(1.0f), number + rest)};
}

}  // namespace sheaf
