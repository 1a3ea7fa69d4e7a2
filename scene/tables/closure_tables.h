// Tables of closures that need more than their words: one array of floats for all, whose parts words refer to.
//
// A table begins at a multiple of kTableBlock floats, with a tag; the number of that block stands in a word, where it
// is exact and takes part in no arithmetic. Lanes behind a run's end hold whatever words were there before, so a table
// is told from what is none by its tag, which is no finite number, as all that stands in tables is.
#pragma once

#include "core/record_table.h"

#include <bit>

namespace sheaf {

/// Tables begin at multiples of so many floats.
inline constexpr int kTableBlockShift = 6;
inline constexpr std::uint32_t kTableBlock = 1u << kTableBlockShift;
/// The first block is not part of any table; its first float is the number of all blocks.
inline constexpr std::uint32_t kFirstTable = 1;
/// Most blocks: a float tells their numbers apart, and floats are reached by 32-bit indices.
inline constexpr std::uint32_t kMaxTableBlocks = 1u << 24;

/// First words of tables, as bits: none is a finite number.
enum class TableTag : std::uint32_t { kMeasured = 0x7fc01001u, kPhase = 0x7fc01002u };

/// Where a lane's table begins.
template <class L> struct TablePlace {
  typename L::Uint first;  ///< into SceneView::closure_tables
  typename L::Mask valid;  ///< false: there is no such table, nor one in any other lane
};

/// The beginnings of the tables that a word refers to; lanes that refer to none get that of one that does.
template <class L> SHEAF_INLINE TablePlace<L> find_table(const float* tables, Float<L> word, TableTag tag) {
  using F = Float<L>;
  using U = Uint<L>;
  const auto inside = (word >= F(0.0f)) & (word < F(tables[0]));
  const U first = to_uint(select(inside, word, F(0.0f))) << kTableBlockShift;
  const auto valid = float_bits(gather(tables, first)) == U(static_cast<std::uint32_t>(tag));
  if (all(valid)) return {first, valid};
  const std::uint32_t lanes = mask_bits(valid);
  if (lanes == 0) return {U(0u), valid};
  alignas(kSimdAlignment) std::uint32_t all_first[L::width];
  store(all_first, first);
  return {select(valid, first, U(all_first[std::countr_zero(lanes)])), typename L::Mask(true)};
}

/// The record at the floats [first, first + kLeafCount).
template <class L, template <class> class Record>
SHEAF_INLINE Record<L> load_table_record(const float* tables, Uint<L> first) {
  Record<L> record;
  std::apply(
      [&](auto&... leaf) SHEAF_LAMBDA_INLINE {
        std::uint32_t k = 0;
        ((leaf = gather(tables, first + Uint<L>(k++))), ...);
      },
      leaves(record));
  return record;
}

/// What a measured BRDF's table begins with, behind its tag. Blocks are counted from the table's own.
template <class L> struct MeasuredHead {
  typename L::Float phi_count, theta_count;  ///< incident directions
  typename L::Float isotropic;               ///< 1: azimuths are relative to the incident one
  typename L::Float reduction;  ///< 2, 4: azimuths span such a part of the turn, the rest follows by symmetry
  typename L::Float jacobian;   ///< 1: the values are to be multiplied by ndf / (4 sigma)
  typename L::Float ndf_width, ndf_height, sigma_width, sigma_height;  ///< each at least 2
  typename L::Float vndf_width, vndf_height, sample_width, sample_height;
  typename L::Float channels;  ///< 3, or one for each wavelength
  typename L::Float phi_block, theta_block, ndf_block, sigma_block, vndf_block, luminance_block, value_block;
  static constexpr auto fields(auto& s) {
    return std::tie(s.phi_count, s.theta_count, s.isotropic, s.reduction, s.jacobian, s.ndf_width, s.ndf_height,
                    s.sigma_width, s.sigma_height, s.vndf_width, s.vndf_height, s.sample_width, s.sample_height,
                    s.channels, s.phi_block, s.theta_block, s.ndf_block, s.sigma_block, s.vndf_block, s.luminance_block,
                    s.value_block);
  }
};

/// The same of a phase function: behind it the density over the cosine at `count` places, per unit of the cosine, and
/// its integral up to each.
template <class L> struct PhaseHead {
  typename L::Float count;  ///< at least 2
  static constexpr auto fields(auto& s) { return std::tie(s.count); }
};

}  // namespace sheaf
