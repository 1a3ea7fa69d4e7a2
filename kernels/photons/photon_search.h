// Search of photon maps around a point: descends the tree level by level, 16 boxes of a group at a time, and passes on
// lists of blocks in ascending order.
#pragma once

#include "core/sampling/octahedral.h"
#include "core/simd/prefetch.h"
#include "core/simd/simd_compress.h"
#include "core/simd/simd_small_integers.h"
#include "kernels/photons/photon_map.h"

#include <bit>
#include <span>
#include <vector>

namespace sheaf {

/// Minimum |cosine| between the normal at a vertex and the normal of a photon's surface.
inline constexpr float kSameSide = 0.5f;

/// Entries of a list of blocks: the index, and what is known about the block's photons.
inline constexpr std::uint32_t kBlockIndex = (1u << 28) - 1;
inline constexpr std::uint32_t kBlockLit = 1u << 29;     ///< all photons arrive on the side of the vertex's normal
inline constexpr std::uint32_t kBlockInside = 1u << 30;  ///< it is full, and all photons lie within the radius
inline constexpr std::uint32_t kBlockMixed = 1u << 31;   ///< some photons may not match the vertex

/// A vertex that looks photons up, in all lanes.
template <class L> struct PhotonQuery {
  Vec3<L> p;           ///< world space
  Vec3<L> ng;          ///< geometric normal
  Uint<L> edges_left;  ///< maximum number of segments of a photon's path

  /// Whether surfaces with this normal belong to that of the vertex. `surface`: see photon_surface().
  SHEAF_INLINE Mask<L> matches_normal(Uint<L> surface) const {
    const Vec3<L> n = decode_octahedral_direction<L>(surface);
    const Float<L> cosine = dot(n, ng);
    return cosine * cosine > dot(n, n) * Float<L>(kSameSide * kSameSide);
  }
  /// Whether paths to photons are too long for the vertex.
  SHEAF_INLINE Mask<L> exceeds_depth(Uint<L> surface) const {
    return edges_left < (surface & Uint<L>(kMaxPhotonEdges));
  }
};

/// A list of blocks, with their boxes relative to a vertex.
struct BlockList {
  /// Lists longer than this are passed on.
  static constexpr int kLong = 240;
  static constexpr int kSize = kLong + static_cast<int>(kPhotonBlock);

  std::uint32_t entries[kSize];  ///< see kBlockIndex
  float low[3][kSize];           ///< lower corner of the block's box, m from the vertex
  float step[3][kSize];          ///< one step of positions, m
  int count = 0;
};

/// Lists of nodes of two levels, which searches reuse.
struct PhotonSearchLists {
  std::vector<std::uint32_t> nodes = std::vector<std::uint32_t>(64), below = nodes;
};

/// Photons that a search has added up itself, because their block lies inside the sphere.
template <class L> struct SummedPhotons {
  Spectrum<L> power;          ///< of those that arrive on the side of the vertex's normal, W
  std::uint32_t photons = 0;  ///< number, of either side
};

namespace photon_search {

/// Number of groups of blocks that are prefetched ahead.
inline constexpr std::size_t kGroupsAhead = 16;
/// Minimum squared cosine between the normals of vertex and block for photons to arrive on the same side of both: the
/// difference of the unit normals is less than kOneSidedCosine.
inline constexpr float kAlignedCosine2 = 0.9997f;
static_assert(2 - 2 * kAlignedCosine2 < 2 * kOneSidedCosine * kOneSidedCosine);

/// The distances between a point and the sides of the boxes of some nodes: positive outside.
template <class L> struct BoxSides {
  Vec3<L> below, above;

  SHEAF_INLINE BoxSides(const PhotonGroup& group, std::uint32_t at, Vec3<L> p) {
    side(group, at, 0, p.x, below.x, above.x);
    side(group, at, 1, p.y, below.y, above.y);
    side(group, at, 2, p.z, below.z, above.z);
  }
  /// Squared distance to the nearest point of each box, m^2.
  SHEAF_INLINE Float<L> nearest() const {
    const Float<L> zero(0.0f);
    const Vec3<L> gap{max(max(below.x, above.x), zero), max(max(below.y, above.y), zero),
                      max(max(below.z, above.z), zero)};
    return dot(gap, gap);
  }
  /// Squared distance to the farthest point.
  SHEAF_INLINE Float<L> farthest() const {
    const Vec3<L> reach{min(below.x, above.x), min(below.y, above.y), min(below.z, above.z)};
    return dot(reach, reach);
  }
  /// Appends the boxes of `bits` to a list, as lower corners and steps of positions.
  SHEAF_INLINE void append(std::uint32_t bits, BlockList& list) const {
    append(below.x, above.x, 0, bits, list);
    append(below.y, above.y, 1, bits, list);
    append(below.z, above.z, 2, bits, list);
  }

 private:
  static SHEAF_INLINE void append(Float<L> below, Float<L> above, int axis, std::uint32_t bits, BlockList& list) {
    compress_store(list.low[axis] + list.count, below, bits);
    const float of_side = 1.0f / static_cast<float>(kPhotonPosition[axis].max);
    compress_store(list.step[axis] + list.count, (below + above) * Float<L>(-of_side), bits);
  }
  static SHEAF_INLINE void side(const PhotonGroup& group, std::uint32_t at, int axis, Float<L> p, Float<L>& below,
                                Float<L>& above) {
    const Float<L> offset = Float<L>(group.low[axis]) - p, step(group.step[axis]);
    Float<L> low, high;
    load(group.boxes[axis] + at, low), load(group.boxes[axis + 3] + at, high);
    below = fma(low, step, offset);
    above = -fma(high, step, offset);
  }
};

/// The lanes set in `bits`.
template <class L> SHEAF_INLINE Mask<L> bit_lanes(std::uint32_t bits) {
  alignas(kSimdAlignment) static constexpr std::uint32_t kBits[16] = {
      1u << 0, 1u << 1, 1u << 2,  1u << 3,  1u << 4,  1u << 5,  1u << 6,  1u << 7,
      1u << 8, 1u << 9, 1u << 10, 1u << 11, 1u << 12, 1u << 13, 1u << 14, 1u << 15};
  Uint<L> lane;
  load(kBits, lane);
  return (lane & Uint<L>(bits)) != Uint<L>(0u);
}

/// Adds the powers of the blocks [at, at + L::width) of `lanes`.
template <class L>
SHEAF_INLINE void add_powers(const PhotonBlockGroup& group, std::uint32_t at, Mask<L> lanes, std::uint32_t powers,
                             Spectrum<L>& sum) {
  Uint<L> high;
  load(group.power_steps + at, high);
  const Float<L> step = select(lanes, bits_float(high << 16), Float<L>(0.0f));
  Spectrum<L> power(Float<L>(0.0f));
  load(group.powers[0] + at, power.c0), load(group.powers[1] + at, power.c1), load(group.powers[2] + at, power.c2);
  if (powers == 4) load(group.powers[3] + at, power.c3);
  sum = {fma(power.c0, step, sum.c0), fma(power.c1, step, sum.c1), fma(power.c2, step, sum.c2),
         fma(power.c3, step, sum.c3)};
}

/// Appends the nodes [at, at + L::width) of `lanes`. Writes kWidth values. Returns the number of nodes.
template <class L> SHEAF_INLINE int append(Uint<L> nodes, Mask<L> lanes, std::uint32_t* out) {
  const std::uint32_t bits = mask_bits(lanes);
  compress_store(out, nodes, bits);
  return std::popcount(bits);
}

/// Appends the nodes of a group that overlap the sphere of squared radius `within`, m^2. Returns their number.
template <class L>
SHEAF_INLINE int append_near_groups(const PhotonGroup& group, std::uint32_t first, const PhotonQuery<L>& query,
                                    Float<L> within, std::uint32_t* out) {
  int count = 0;
  for (std::uint32_t at = 0; at < kPhotonBlock; at += static_cast<std::uint32_t>(L::width)) {
    const Uint<L> node = Uint<L>(at) + L::index();
    const BoxSides<L> sides(group, at, query.p);
    count += append<L>(Uint<L>(first) + node, (sides.nearest() < within) & (node < Uint<L>(group.count)), out + count);
  }
  return count;
}

/// Appends the blocks of a group that overlap the sphere of squared radius `within`, m^2, without those whose photons
/// do not match the vertex. `sum`, unless null, receives blocks inside the sphere.
template <class L>
SHEAF_INLINE void append_near_blocks(const PhotonMapView& map, std::uint32_t index, const PhotonQuery<L>& query,
                                     Float<L> within, SummedPhotons<L>* sum, BlockList& list) {
  using F = Float<L>;
  using U = Uint<L>;
  const PhotonBlockGroup& group = map.block_groups[index];
  for (std::uint32_t at = 0; at < kPhotonBlock; at += static_cast<std::uint32_t>(L::width)) {
    const U node = U(at) + L::index();
    const BoxSides<L> sides(group, at, query.p);
    Mask<L> near = (sides.nearest() < within) & (node < U(group.count));
    if (!any(near)) continue;
    // Compare the surfaces
    U surface;
    load(group.surfaces + at, surface);
    const Mask<L> mixed = (surface & U(kMixedNormals)) != U(0u);
    const Vec3<L> n = decode_octahedral_direction<L>(surface);
    const F cosine = dot(n, query.ng), cosine2 = cosine * cosine, length2 = dot(n, n);
    near = near & (mixed | (cosine2 > length2 * F(kSameSide * kSameSide)));
    const U blocks = U(index * kPhotonBlock) + node;
    const Mask<L> inside = (sides.farthest() < within) & (blocks < U(map.size / kPhotonBlock));
    const Mask<L> tested = mixed | query.exceeds_depth(surface);
    U entries = blocks | select(inside, U(kBlockInside), U(0u)) | select(tested, U(kBlockMixed), U(0u));
    if (sum != nullptr) {
      // Add up blocks inside
      const Mask<L> aligned = bit_lanes<L>(group.one_sided >> at) & (cosine2 > length2 * F(kAlignedCosine2)) & !mixed;
      const Mask<L> lit = aligned & (cosine > F(0.0f)), summed = near & inside & aligned & !tested;
      if (any(summed)) {
        add_powers<L>(group, at, summed & lit, map.powers, sum->power);
        sum->photons += kPhotonBlock * static_cast<std::uint32_t>(std::popcount(mask_bits(summed)));
        near = near & !summed;
      }
      entries = entries | select(lit, U(kBlockLit), U(0u));
    }
    const std::uint32_t bits = mask_bits(near);
    compress_store(list.entries + list.count, entries, bits);
    sides.append(bits, list);
    list.count += std::popcount(bits);
  }
}

/// The groups of level 0 that may overlap the sphere of squared radius `within`, m^2, in ascending order.
template <class L>
std::span<const std::uint32_t> near_block_groups(const PhotonMapView& map, const PhotonQuery<L>& query, Float<L> within,
                                                 PhotonSearchLists& lists) {
  std::size_t count = 1;
  lists.nodes[0] = 0;
  for (int level = map.levels - 1; level > 0; --level) {
    const PhotonGroup* groups = map.groups[static_cast<std::size_t>(level)];
    std::size_t below = 0;
    for (std::size_t i = 0; i < count; ++i) {
      if (lists.below.size() < below + kPhotonBlock) lists.below.resize(2 * lists.below.size());
      const std::uint32_t group = lists.nodes[i];
      below += static_cast<std::size_t>(
          append_near_groups<L>(groups[group], group * kPhotonBlock, query, within, lists.below.data() + below));
    }
    lists.nodes.swap(lists.below);
    count = below;
  }
  return {lists.nodes.data(), count};
}

/// Prefetches what a search reads of a group of blocks: the fourth power lies in the last cache line.
SHEAF_INLINE void prefetch_group(const PhotonMapView& map, std::uint32_t index) {
  const auto* bytes = reinterpret_cast<const std::byte*>(map.block_groups + index);
  const std::size_t lines = sizeof(PhotonBlockGroup) / 64 - (map.powers == 4 ? 0u : 1u);
  for (std::size_t line = 0; line < lines; ++line) prefetch(bytes + 64 * line);
}
static_assert(sizeof(PhotonGroup) + sizeof(PhotonBlockGroup::surfaces) + sizeof(PhotonBlockGroup::power_steps) +
                  3 * sizeof(PhotonBlockGroup::powers[0]) ==
              sizeof(PhotonBlockGroup) - 64);

}  // namespace photon_search

/// Calls f(list) for lists of the blocks that may hold photons within a distance of the vertex, in ascending order.
/// `within`: squared distance, m^2; f may shrink it. `sum`: null, or receives the photons of some blocks that lie
/// inside, which f does not get. `lists`: for the search itself. The map must not be empty.
template <class L, class F>
void for_blocks_near(const PhotonMapView& map, const PhotonQuery<L>& query, const float& within, SummedPhotons<L>* sum,
                     PhotonSearchLists& lists, F&& f) {
  const auto groups = photon_search::near_block_groups<L>(map, query, Float<L>(within), lists);
  const auto prefetch_ahead = [&](std::size_t i) {
    if (i < groups.size()) photon_search::prefetch_group(map, groups[i]);
  };
  for (std::size_t i = 0; i < photon_search::kGroupsAhead; ++i) prefetch_ahead(i);
  BlockList list;
  for (std::size_t i = 0; i < groups.size(); ++i) {
    prefetch_ahead(i + photon_search::kGroupsAhead);
    photon_search::append_near_blocks<L>(map, groups[i], query, Float<L>(within), sum, list);
    if (list.count == 0 || (i + 1 < groups.size() && list.count <= BlockList::kLong)) continue;
    f(static_cast<const BlockList&>(list));
    list.count = 0;
  }
}

/// Photons [at, at + L::width) of a block that match the vertex, with their squared distances, m^2.
template <class L> struct NearPhotons {
  Mask<L> lanes;
  Float<L> squared;
};

/// Block i of a list, for the vertex of the list.
template <class L> class NearBlock {
 public:
  SHEAF_INLINE NearBlock(const PhotonMapView& map, const BlockList& list, int i)
      : map_(map), list_(list), i_(i), entry_(list.entries[i]) {}

  /// `within`: squared radius, m^2. Distances in blocks inside the sphere are 0 unless `needs_distances`.
  SHEAF_INLINE NearPhotons<L> near(std::uint32_t at, const PhotonQuery<L>& query, float within,
                                   bool needs_distances) const {
    NearPhotons<L> near{Mask<L>(true), Float<L>(0.0f)};
    if (needs_distances || (entry_ & kBlockInside) == 0) {
      Uint<L> words;
      load(block().positions + at, words);
      const Vec3<L> d{offset(words, 0), offset(words, 1), offset(words, 2)};
      near.squared = dot(d, d);
      near.lanes = near.squared < Float<L>(within);
    }
    if ((entry_ & kBlockMixed) != 0) {
      const Uint<L> surfaces = surface(at), photon = Uint<L>(index() * kPhotonBlock + at) + L::index();
      near.lanes =
          near.lanes & query.matches_normal(surfaces) & !query.exceeds_depth(surfaces) & (photon < Uint<L>(map_.size));
    }
    return near;
  }

  std::uint32_t index() const { return entry_ & kBlockIndex; }
  /// Whether all photons are known to arrive on the side of the vertex's normal.
  bool is_lit() const { return (entry_ & kBlockLit) != 0; }
  /// Columns of the photons [at, at + L::width): octahedral directions; surfaces, see photon_surface(); powers in
  /// steps.
  SHEAF_INLINE Uint<L> direction(std::uint32_t at) const {
    Uint<L> out;
    load(block().directions + at, out);
    return out;
  }
  SHEAF_INLINE Uint<L> surface(std::uint32_t at) const {
    Uint<L> out;
    load(block().surfaces + at, out);
    return out;
  }
  SHEAF_INLINE Spectrum<L> power(std::uint32_t at) const {
    Uint<L> words;
    load(block().powers + at, words);
    const auto component = [&](int k) SHEAF_LAMBDA_INLINE { return to_float(photon_power(map_.powers, k).of(words)); };
    // Without a fourth lane, paths ignore its value.
    return {component(0), component(1), component(2), component(3)};
  }
  /// Power of one step, W.
  SHEAF_INLINE float power_step() const { return map_.group_of(index()).power_step(index() % kPhotonBlock); }

 private:
  const PhotonBlock& block() const { return map_.blocks[index()]; }
  /// Distances along an axis. `words`: see PhotonBlock::positions.
  SHEAF_INLINE Float<L> offset(Uint<L> words, int axis) const {
    return fma(to_float(kPhotonPosition[axis].of(words)), Float<L>(list_.step[axis][i_]),
               Float<L>(list_.low[axis][i_]));
  }

  const PhotonMapView& map_;
  const BlockList& list_;
  int i_;
  std::uint32_t entry_;
};

}  // namespace sheaf
