// Discrete and piecewise-constant distributions: alias tables for discrete choices, and CDFs over the unit interval and
// the unit square for textured lights and environment maps.
#pragma once

#include "core/lane_array.h"
#include "core/vec.h"

#include <span>
#include <vector>

namespace sheaf {

/// The largest float below 1.
inline constexpr float kOneMinusEpsilon = 0x1.fffffep-1f;

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
/// Probabilities are normalised in double precision.
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

/// Maximum number of entries of a CDF. Single precision still separates this many cells of the unit interval.
inline constexpr std::size_t kMaxCdfEntries = std::size_t{1} << 20;

/// The cell of a CDF that contains a uniform number.
template <class L> struct CdfCell {
  typename L::Uint index;
  typename L::Float begin;        ///< value of the CDF at the start of the cell
  typename L::Float probability;  ///< of the cell
};

/// The probability of cell `index` of a CDF that begins at cdf[offset].
template <class L> SHEAF_INLINE CdfCell<L> cdf_cell(const float* cdf, typename L::Uint offset, typename L::Uint index) {
  using U = typename L::Uint;
  const Float<L> begin = gather(cdf, offset + index);
  return {index, begin, gather(cdf, offset + index + U(1u)) - begin};
}

/// Finds the cell with cdf[cell] <= u < cdf[cell + 1] among `count` cells, whose count + 1 bounds begin at cdf[offset].
/// u is in [0, 1). Branchless binary search: every lane takes the same number of steps. Never returns cells of zero
/// width.
template <class L>
SHEAF_INLINE CdfCell<L> find_cell(const float* cdf, typename L::Uint offset, std::uint32_t count, typename L::Float u) {
  using U = typename L::Uint;
  U index(0u);
  for (std::uint32_t step = std::bit_floor(count - 1); step != 0; step >>= 1) {
    const U probe = index + U(step);
    index = select(gather(cdf, offset + min(probe, U(count))) <= u, probe, index);
  }
  return cdf_cell<L>(cdf, offset, index);
}

/// Maps u within its cell to a position in [0, 1) over all `count` cells. Keeps a margin to the bounds of the cell, so
/// that cell_at() finds the same cell again.
template <class L>
SHEAF_INLINE Float<L> position_in_cell(const CdfCell<L>& cell, std::uint32_t count, typename L::Float u) {
  using F = typename L::Float;
  constexpr float kMargin = 0x1p-22f;
  const F index = to_float(cell.index);
  const F position = index + (u - cell.begin) / cell.probability;
  return clamp(position, index * F(1.0f + kMargin), (index + F(1.0f)) * F(1.0f - kMargin)) /
         F(static_cast<float>(count));
}

/// The index of the cell that contains x, among `count` equal cells of [0, 1). Clamps x outside to the nearest cell.
template <class L> SHEAF_INLINE Uint<L> cell_at(typename L::Float x, std::uint32_t count) {
  using F = typename L::Float;
  const F last(static_cast<float>(count - 1));
  return to_uint(clamp(x * F(static_cast<float>(count)), F(0.0f), last));
}

/// A point sampled from a Distribution1D.
template <class L> struct Sample1D {
  typename L::Float x;     ///< in [0, 1)
  typename L::Float pdf;   ///< density at x over [0, 1)
  typename L::Uint index;  ///< of the value at x
};

/// A piecewise-constant density over [0, 1) in proportion to a list of values (Pharr et al., "Physically Based
/// Rendering", 4th ed., A.4.7).
///
/// The bounds of the CDF are multiples of 2^-24, like the random numbers. Every positive value gets at least one such
/// step. So pdf() is exactly the density of sample(), and every positive value can be sampled.
class Distribution1D {
 public:
  /// Takes 1 to kMaxCdfEntries values. Throws SceneError unless they are finite and non-negative with a positive sum.
  explicit Distribution1D(std::span<const float> values);

  /// Samples a point with u in [0, 1). The point is monotonic in u and never lies where the value is 0.
  template <class L> SHEAF_INLINE Sample1D<L> sample(typename L::Float u) const {
    const CdfCell<L> cell = find_cell<L>(cdf_.data(), Uint<L>(0u), size(), u);
    return {position_in_cell(cell, size(), u), cell.probability * Float<L>(static_cast<float>(size())), cell.index};
  }

  /// The density at x in [0, 1].
  template <class L> SHEAF_INLINE Float<L> pdf(typename L::Float x) const {
    const CdfCell<L> cell = cdf_cell<L>(cdf_.data(), Uint<L>(0u), cell_at<L>(x, size()));
    return cell.probability * Float<L>(static_cast<float>(size()));
  }

  /// Number of values.
  std::uint32_t size() const { return static_cast<std::uint32_t>(cdf_.size() - 1); }
  /// The integral of the values over [0, 1]: their mean.
  double integral() const { return integral_; }

 private:
  std::vector<float> cdf_;
  double integral_ = 0;
};

/// A point sampled from a Distribution2D.
template <class L> struct Sample2D {
  Vec2<L> p;                     ///< in [0, 1)^2
  typename L::Float pdf;         ///< density at p over the unit square
  typename L::Uint column, row;  ///< of the value at p
};

/// A piecewise-constant density over [0, 1)^2 in proportion to a grid of values: the marginal density of the rows, then
/// the conditional density within the row (Pharr et al., 4th ed., A.5.6). As exact as Distribution1D.
class Distribution2D {
 public:
  /// `values` are in row-major order, `width` to a row, with row 0 at y = 0. Throws SceneError unless width and height
  /// are in [1, kMaxCdfEntries] and match the number of values, and the values are finite and non-negative with a
  /// positive sum.
  Distribution2D(std::span<const float> values, std::size_t width, std::size_t height);

  /// Samples a point with u and v in [0, 1): v selects the row, u the column. The point never lies where the value is
  /// 0.
  template <class L> SHEAF_INLINE Sample2D<L> sample(typename L::Float u, typename L::Float v) const {
    const CdfCell<L> row = find_cell<L>(marginal_.data(), Uint<L>(0u), height(), v);
    const CdfCell<L> column = find_cell<L>(conditional_.data(), row_begin<L>(row.index), width_, u);
    return {{position_in_cell(column, width_, u), position_in_cell(row, height(), v)},
            density<L>(row, column),
            column.index,
            row.index};
  }

  /// The density at p in [0, 1]^2.
  template <class L> SHEAF_INLINE Float<L> pdf(Vec2<L> p) const {
    const CdfCell<L> row = cdf_cell<L>(marginal_.data(), Uint<L>(0u), cell_at<L>(p.y, height()));
    return density<L>(row, cdf_cell<L>(conditional_.data(), row_begin<L>(row.index), cell_at<L>(p.x, width_)));
  }

  std::uint32_t width() const { return width_; }
  std::uint32_t height() const { return static_cast<std::uint32_t>(marginal_.size() - 1); }
  /// The integral of the values over the unit square: their mean.
  double integral() const { return integral_; }

 private:
  template <class L> SHEAF_INLINE Uint<L> row_begin(typename L::Uint row) const { return row * Uint<L>(width_ + 1); }
  template <class L> SHEAF_INLINE Float<L> density(const CdfCell<L>& row, const CdfCell<L>& column) const {
    const float cells = static_cast<float>(width_) * static_cast<float>(height());
    return row.probability * column.probability * Float<L>(cells);
  }

  std::uint32_t width_ = 0;
  std::vector<float> conditional_;  // height rows of width + 1 bounds
  std::vector<float> marginal_;     // height + 1 bounds
  double integral_ = 0;
};

}  // namespace sheaf
