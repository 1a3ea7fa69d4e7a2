// Tables for closures whose data exceeds their parameter words: one array of floats, referenced from parameter words.
//
// A table starts at a multiple of kTableBlock floats, with a tag. A parameter word holds the block number as a float,
// exactly and without arithmetic on it. Lanes past the end of a run hold stale words. The tag identifies valid tables:
// it is a NaN, and all other data in tables is finite.
#pragma once

#include "core/soa/lane_array.h"
#include "core/soa/record_table.h"

#include <bit>

namespace sheaf {

/// Tables start at multiples of 2^kTableBlockShift floats.
inline constexpr int kTableBlockShift = 6;
inline constexpr std::uint32_t kTableBlock = 1u << kTableBlockShift;
/// Block 0 belongs to no table; its first float is the total number of blocks.
inline constexpr std::uint32_t kFirstTable = 1;
/// Maximum number of blocks: floats represent their numbers exactly, and 32-bit indices address all floats.
inline constexpr std::uint32_t kMaxTableBlocks = 1u << 24;

/// First words of tables, as bits; none is a finite float.
enum class TableTag : std::uint32_t { kMeasured = 0x7fc01001u, kPhase = 0x7fc01002u, kHalfAngle = 0x7fc01003u };

/// The start of each lane's table.
template <class L> struct FoundTable {
  typename L::Uint first;  ///< into MaterialView::closure_tables
  typename L::Mask valid;  ///< false: neither this lane nor any other refers to such a table
};

/// Finds the tables that a word refers to. Lanes without a valid table get that of another lane, if any has one.
template <class L> SHEAF_INLINE FoundTable<L> find_table(const float* tables, Float<L> word, TableTag tag) {
  using F = Float<L>;
  using U = Uint<L>;
  const auto inside = (word >= F(0.0f)) & (word < F(tables[0]));
  const U first = to_uint(select(inside, word, F(0.0f))) << kTableBlockShift;
  const auto valid = float_bits(gather(tables, first)) == U(static_cast<std::uint32_t>(tag));
  if (all(valid)) return {first, valid};
  const std::uint32_t lanes = mask_bits(valid);
  if (lanes == 0) return {U(0u), valid};
  return {select(valid, first, U(LaneArray<U>(first)[std::countr_zero(lanes)])), typename L::Mask(true)};
}

/// Gathers a record from the floats [first, first + kLeafCount).
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

/// Header of a measured BRDF's table, after the tag. Block numbers are relative to the table's start.
template <class L> struct MeasuredHead {
  typename L::Float phi_count, theta_count;  ///< number of incident directions
  typename L::Float isotropic;               ///< 1: azimuths are relative to the incident one
  typename L::Float reduction;  ///< 2, 4: azimuths span 1/2 or 1/4 of the circle; the rest follows by symmetry
  typename L::Float jacobian;   ///< 1: multiply values by ndf / (4 sigma)
  typename L::Float ndf_width, ndf_height, sigma_width, sigma_height;  ///< each at least 2
  typename L::Float vndf_width, vndf_height, sample_width, sample_height;
  typename L::Float channels;  ///< 3, or one per wavelength
  typename L::Float phi_block, theta_block, ndf_block, sigma_block, vndf_block, luminance_block, value_block;
  static constexpr auto fields(auto& s) {
    return std::tie(s.phi_count, s.theta_count, s.isotropic, s.reduction, s.jacobian, s.ndf_width, s.ndf_height,
                    s.sigma_width, s.sigma_height, s.vndf_width, s.vndf_height, s.sample_width, s.sample_height,
                    s.channels, s.phi_block, s.theta_block, s.ndf_block, s.sigma_block, s.vndf_block, s.luminance_block,
                    s.value_block);
  }
};

/// Header of the table of an isotropic BRDF over the half and difference angles of Rusinkiewicz 1998, after the tag.
template <class L> struct HalfAngleHead {
  typename L::Float alpha;                                    ///< roughness of the GGX distribution that samples follow
  typename L::Float phi_count, theta_d_count, theta_h_count;  ///< number of angles, at least 2
  typename L::Float channels;                                 ///< 3, or one per wavelength
  typename L::Float phi_block, theta_d_block, theta_h_block;  ///< the angles
  typename L::Float value_block;                              ///< values as in PolarizedBrdf
  static constexpr auto fields(auto& s) {
    return std::tie(s.alpha, s.phi_count, s.theta_d_count, s.theta_h_count, s.channels, s.phi_block, s.theta_d_block,
                    s.theta_h_block, s.value_block);
  }
};

/// Header of a phase function's table. It is followed by the pdf over the cosine at `count` points, per unit of the
/// cosine, and by its cdf at these points.
template <class L> struct PhaseHead {
  typename L::Float count;  ///< at least 2
  static constexpr auto fields(auto& s) { return std::tie(s.count); }
};

}  // namespace sheaf
