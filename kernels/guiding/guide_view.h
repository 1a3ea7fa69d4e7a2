// The guide as kernels read it: mixtures, and the trees that map a vertex to its mixture.
//
// There is one tree for each side that surfaces may face and one for media, all over the same cube. A tree halves the
// cube along x, y and z alternately, so the path to a leaf is the Morton code of a point. The first kGuideTopBits
// levels are a table.
#pragma once

#include "kernels/guiding/guide_mixture.h"

namespace sheaf {

/// Sides: surfaces by the axis closest to their normal, and media.
inline constexpr std::uint32_t kGuideMedia = 6, kGuideSides = 7;
/// Number of levels of a tree, and of its table.
inline constexpr int kGuideBits = 30, kGuideTopBits = 12;
/// Bit of a node that is a leaf; the other bits are the row of its mixture.
inline constexpr std::uint32_t kGuideLeaf = 0x80000000u;

/// Row 0 of `mixtures` is untrained: the BSDF samples all directions.
struct GuideView {
  const GuideMixture* mixtures = nullptr;
  const std::uint32_t* roots = nullptr;     ///< 2^kGuideTopBits nodes per side; null: untrained
  const std::uint32_t* children = nullptr;  ///< two nodes for each inner node
  /// Per mixture: mean light that vertices of its cell scatter, over their throughput; -1: unknown.
  const float* means = nullptr;
  Vec3f low{};      ///< corner of the cube
  float scale = 0;  ///< cells of the finest level per meter
};

/// Side of a surface whose normal, on the viewer's side, is `n`.
template <class L> SHEAF_INLINE Uint<L> guide_side(Vec3<L> n) {
  using F = Float<L>;
  using U = Uint<L>;
  const Vec3<L> a = abs(n);
  const Mask<L> x = (a.x >= a.y) & (a.x >= a.z), y = a.y >= a.z;
  const F along = select(x, n.x, select(y, n.y, n.z));
  return select(x, U(0u), select(y, U(2u), U(4u))) + select(along < F(0.0f), U(1u), U(0u));
}

/// Inserts two zeros between each of the low 10 bits of `x`.
template <class U> SHEAF_INLINE U spread_bits(U x) {
  x = (x | (x << 16)) & U(0x030000ffu);
  x = (x | (x << 8)) & U(0x0300f00fu);
  x = (x | (x << 4)) & U(0x030c30c3u);
  return (x | (x << 2)) & U(0x09249249u);
}

/// Morton code of a point, kGuideBits long.
template <class L> SHEAF_INLINE Uint<L> guide_code(const GuideView& guide, Vec3<L> p) {
  using F = Float<L>;
  const auto cell = [&guide](F v, float low) SHEAF_LAMBDA_INLINE {
    constexpr float kCells = 1 << (kGuideBits / 3);
    return spread_bits(to_uint(clamp((v - F(low)) * F(guide.scale), F(0.0f), F(kCells - 1))));
  };
  return (cell(p.x, guide.low.x) << 2) | (cell(p.y, guide.low.y) << 1) | cell(p.z, guide.low.z);
}

/// Row of the mixture for a side and a Morton code.
template <class L> SHEAF_INLINE Uint<L> guide_row(const GuideView& guide, Uint<L> side, Uint<L> code) {
  using U = Uint<L>;
  if (guide.roots == nullptr) return U(0u);
  U node = gather(guide.roots, (side << kGuideTopBits) + (code >> (kGuideBits - kGuideTopBits)));
  U bits = code << (32 - kGuideBits + kGuideTopBits);
  for (;;) {
    const auto inner = (node & U(kGuideLeaf)) == U(0u);
    if (!any(inner)) return node & U(~kGuideLeaf);
    const U child = gather(guide.children, select(inner, (node << 1) + (bits >> 31), U(0u)));
    node = select(inner, child, node);
    bits = bits << 1;
  }
}

}  // namespace sheaf
