// Discrete distributions as tables of quantiles: to draw from one is to read one row, without any search, and numbers
// that are stratified stay so.
//
// Every row has the same probability. A row is a part of an entry that is likely, or a run of entries that are less so
// and share it equally. What that takes from the proportions of the weights is chosen to be least where it would cost
// variance, and probabilities are told as they are, not as they were wished for.
#pragma once

#include "core/lanes.h"

#include <span>
#include <vector>

namespace sheaf {

/// A quantile: a run of entries in equal shares, or one of the equal parts of an entry that has quantiles of its own.
/// In bits: the first entry, 17; 1 for a run; its length, or the number of the part.
struct Quantile {
  std::uint32_t bits;

  static Quantile of_run(std::uint32_t first, std::uint32_t length) { return {first << 15 | 1u << 14 | length}; }
  static Quantile of_part(std::uint32_t entry, std::uint32_t number) { return {entry << 15 | number}; }
  std::uint32_t first() const { return bits >> 15; }
  /// How many entries it has a share of.
  std::uint32_t length() const { return (bits >> 14 & 1u) != 0 ? bits & 0x3fffu : 1u; }
};

/// Rows of a table of quantiles.
inline constexpr std::uint32_t kQuantiles = 1024;
/// Most entries of a quantile. More would leave too few random bits for each.
inline constexpr std::uint32_t kMaxQuantileRun = 256;
/// Most entries of a distribution: runs of the greatest length and gaps between them take all quantiles.
inline constexpr std::uint32_t kMaxQuantileEntries = kQuantiles * kMaxQuantileRun / 2;

/// Fills the kQuantiles rows at `table` for `weights`, at most kMaxQuantileEntries, which are finite and not negative,
/// and sets the weights to probabilities: those with which draw_quantile() finds the entries, positive where weights
/// are, and at times between two such places. Returns false, and changes nothing, without any positive weight.
bool build_quantiles(std::span<double> weights, Quantile* table);

/// An entry drawn from a table of quantiles.
template <class L> struct QuantileDraw {
  typename L::Uint index, quantile;
  /// In a run the place in the entry, less 1: negative. Else that times the number of quantiles that the entry has.
  typename L::Float place;

  /// What is left of u, a fresh uniform number in [0, 1). `probability`: of the entry.
  SHEAF_INLINE Float<L> remapped(Float<L> probability) const {
    using F = Float<L>;
    const auto in_run = place < F(0.0f);
    const F parts = select(in_run, F(1.0f), probability * F(static_cast<float>(kQuantiles)));
    return min(select(in_run, place + F(1.0f), place) / parts, F(0x1.fffffep-1f));
  }
};

/// Draws from the table that begins at row tables[table], one for each lane, by u in [0, 1). The index grows with u,
/// and with it remapped() inside of an entry. That keeps about 24 - log2(1 / probability) random bits.
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
