// Picks a light at random from a light tree, in proportion to what its part of the tree may contribute at a point, and
// tells the probability with which it would pick a given one.
//
// The measure of importance is that of Pharr et al., "Physically Based Rendering", 4th ed., section 12.6.3, after Conty
// Estevez and Kulla (HPG 2018), equation 3: power, over squared distance, times the largest cosines that any light of
// the node can have at either end, or somewhat larger ones that cost less to find.
#pragma once

#include "scene/tables/light_tree.h"

#include "core/distribution.h"
#include "core/vec.h"

namespace sheaf {

/// A light drawn from a light tree.
template <class L> struct LightTreeSample {
  typename L::Uint light;        ///< its index; 0 unless valid
  typename L::Float probability; ///< that it is drawn; 0 unless valid
  typename L::Float remapped;    ///< a fresh uniform number in [0, 1) from what is left of u
  typename L::Mask valid;        ///< false: no light can shine here, or the tree is empty
};

namespace light_tree_detail {

/// The least cosine that a light in view is given at either end: what single precision takes for grazing may not be.
inline constexpr float kLeastCosine = 1e-3f;
/// Where both children may contribute, either is drawn with at least this probability. Uniform numbers of 24 bits can
/// still choose it, and products over many levels do not underflow.
inline constexpr float kLeastTurn = 0x1p-20f;
/// Squared distances are kept in this range, which keeps their products finite.
inline constexpr float kNearSquared = 1e-18f, kFarSquared = 1e18f;

/// Where light is wanted.
template <class L> struct Receiver {
  Vec3<L> p;
  Vec3<L> n;                    ///< unit length, or zero
  typename L::Float all_sides;  ///< 1 where there is no normal, else 0
};

template <class L> SHEAF_INLINE Receiver<L> make_receiver(Vec3<L> p, Vec3<L> n, Mask<L> has_normal) {
  const Mask<L> facing = has_normal & (dot(n, n) > Float<L>(0.0f));
  const Float<L> zero(0.0f);
  return {p, select(facing, n, Vec3<L>{zero, zero, zero}), select(facing, zero, Float<L>(1.0f))};
}

/// The power of two which brings a positive x to [1, 2). A division would take longer.
template <class L> SHEAF_INLINE Float<L> reciprocal_power_of_two(typename L::Float x) {
  using U = Uint<L>;
  return bits_float(U(0x7f000000u) - (float_bits(x) & U(0x7f800000u)));
}

/// What a node may contribute: `weight` / `divisor`, up to a factor that its sibling shares.
template <class L> struct Importance { typename L::Float weight, divisor; };

/// The two children of a node.
template <class L> struct NodePair {
  LightNode<L> first, second;
};

template <class L> SHEAF_INLINE NodePair<L> load_pair(const LightTreeView& tree, typename L::Uint first) {
  alignas(kSimdAlignment) std::uint32_t lanes[L::width];
  store(lanes, first);
  const float* rows[L::width];
  for (int lane = 0; lane < L::width; ++lane) rows[lane] = reinterpret_cast<const float*>(tree.nodes + lanes[lane]);
  constexpr int kWords = kLeafCount<LightNode>, kRowWords = sizeof(LightNodeRow) / sizeof(float);
  constexpr int kLoaded = (kWords + 3) / 4 * 4;
  static_assert(kLoaded <= kRowWords);
  typename L::Float words[2][kLoaded];
  for (auto& child : words)
    for (int k = 0; k < kRowWords; k += 4) {
      if (k < kLoaded) load_rows4(rows, child + k);
      for (int lane = 0; lane < L::width; ++lane) rows[lane] += 4;
    }
  return {record_of_words<L, LightNode>(words[0]), record_of_words<L, LightNode>(words[1])};
}

/// The same node in all lanes.
template <class L> SHEAF_INLINE LightNode<L> broadcast(const LightNodeRow& row) {
  using F = Float<L>;
  return {{F(row.center.x), F(row.center.y), F(row.center.z)},
          F(row.radius),
          {F(row.tilt.x), F(row.tilt.y), F(row.tilt.z)},
          F(row.spread),
          F(row.share),
          F(row.cos_theta_e),
          Uint<L>(row.link)};
}

/// Bounds of cosines instead of the largest ones: for a sphere of radius r around a point at distance D, under an angle
/// i, no direction to it has a larger cosine than cos i + r / D, as cos(i - b) <= cos i + sin b; and the same with the
/// cone of normals at the other end, where the sine of the angle w from its axis is at most 1 - (cos w)^2 / 2. All is
/// times D here, which takes one square root.
template <class L> SHEAF_INLINE Importance<L> importance(const LightNode<L>& node, const Receiver<L>& at) {
  using F = Float<L>;
  using U = Uint<L>;
  const Vec3<L> d = node.center - at.p;
  const F squared = clamp(dot(d, d), F(kNearSquared), F(kFarSquared)), distance = sqrt(squared);
  // Brings the distance near 1. Powers of the distance itself might not be finite.
  const F scale = reciprocal_power_of_two<L>(distance);
  // At the light; two sides have two axes.
  const U keep_sign = U(0xffffffffu) ^ ((node.link & U(kLightTwoSided)) << 1);
  const F cos_w = bits_float(float_bits(-dot(node.tilt, d)) & keep_sign);
  const F sin_w = fma(cos_w * cos_w, scale * F(-0.25f), distance);
  const F cos_light = fma(node.spread, sin_w, cos_w) + node.radius;
  // At the receiver, on the side of its normal where the light is.
  const F cos_receiver = fma(at.all_sides, distance, abs(dot(at.n, d))) + node.radius;
  const F one = distance * scale, least = one * F(kLeastCosine);
  const F weight = node.share * clamp(cos_light * scale, least, one) * clamp(cos_receiver * scale, least, one);
  return {select(cos_light > node.cos_theta_e * distance, weight, F(0.0f)),
          one * one * clamp(node.radius * node.radius, squared, F(kFarSquared))};
}

/// The way on from a node, as weights of which only the ratio counts.
template <class L> struct Turn {
  typename L::Float first, second;

  SHEAF_INLINE Float<L> sum() const { return first + second; }
};

template <class L> SHEAF_INLINE Turn<L> turn(const NodePair<L>& pair, const Receiver<L>& at) {
  using F = Float<L>;
  const F zero(0.0f), least(kLeastTurn);
  const Importance<L> a = importance<L>(pair.first, at), b = importance<L>(pair.second, at);
  const F to_first = a.weight * b.divisor, to_second = b.weight * a.divisor;
  return {select(to_first > zero, max(to_first, to_second * least), zero),
          select(to_second > zero, max(to_second, to_first * least), zero)};
}

/// Where a draw stands: `rest` / `whole` of the node's share of u lies before it, and `chosen` / `offered` is the
/// probability of having come here. No division until the end: a walk waits for each of its steps.
template <class L> struct Descent {
  typename L::Float rest, whole, chosen, offered;

  static SHEAF_INLINE Descent at_root(typename L::Float u) {
    return {u, Float<L>(1.0f), Float<L>(1.0f), Float<L>(1.0f)};
  }
  SHEAF_INLINE Mask<L> possible() const { return chosen > Float<L>(0.0f); }

  /// Takes a turn; whether it leads to the first child.
  SHEAF_INLINE Mask<L> take(const Turn<L>& way, Mask<L> active) {
    using F = Float<L>;
    const F sum = way.sum(), here = rest * sum, border = whole * way.first;
    const auto goes_first = here < border;
    const F taken = select(goes_first, way.first, way.second), part = whole * taken;
    const F scale = reciprocal_power_of_two<L>(part), scale_sum = reciprocal_power_of_two<L>(sum);
    rest = select(active, select(goes_first, here, here - border) * scale, rest);
    whole = select(active, part * scale, whole);
    chosen = select(active, chosen * (taken * scale_sum), chosen);
    offered = select(active, offered * (sum * scale_sum), offered);
    return goes_first;
  }
};

/// Goes on from `node` in the lanes of `active`, to a leaf, whose link is kept in `link`.
template <class L>
SHEAF_INLINE LightTreeSample<L> descend(const LightTreeView& tree, const Receiver<L>& at, Descent<L> way,
                                        typename L::Uint link) {
  using F = Float<L>;
  using U = Uint<L>;
  auto active = ((link & U(kLightLeaf)) == U(0u)) & way.possible();
  while (any(active)) {
    const NodePair<L> pair = load_pair<L>(tree, select(active, link & U(kLightIndex), U(0u)));
    const auto goes_first = way.take(turn<L>(pair, at), active);
    link = select(active, select(goes_first, pair.first.link, pair.second.link), link);
    active = active & ((link & U(kLightLeaf)) == U(0u)) & way.possible();
  }
  const auto valid = way.possible();
  const F remapped = clamp(way.rest / select(valid, way.whole, F(1.0f)), F(0.0f), F(kOneMinusEpsilon));
  return {select(valid, link & U(kLightIndex), U(0u)), select(valid, way.chosen / way.offered, F(0.0f)), remapped,
          valid};
}

}  // namespace light_tree_detail

/// Draws a light for the point `p` by `u` in [0, 1). `n`: unit normal for shading; light on either side of it counts.
/// A zero `n` or `has_normal` false stands for a point in a medium. Every light that can shine on `p` has a positive
/// probability. u keeps about 24 - log2(1 / probability) random bits: lights much rarer than 2^-24 share them.
template <class L>
SHEAF_INLINE LightTreeSample<L> sample_light_tree(const LightTreeView& tree, Vec3<L> p, Vec3<L> n, Mask<L> has_normal,
                                                  typename L::Float u) {
  using namespace light_tree_detail;
  using F = Float<L>;
  if (tree.node_count == 0) return {Uint<L>(0u), F(0.0f), u, Mask<L>(false)};
  return descend<L>(tree, make_receiver<L>(p, n, has_normal), Descent<L>::at_root(u), Uint<L>(0u));
}

/// The upper turns for one receiver, which all its candidates have in common.
template <class L> struct LightTreeTop {
  /// For each upper pair the probability of its first child. kAlwaysFirst where there is no pair, as a leaf lies above
  /// it, and kNoTurn where none of its lights can contribute.
  typename L::Float first[kLightTopPairs];

  static constexpr float kAlwaysFirst = 2, kNoTurn = -1;
  static constexpr auto fields(auto& s) { return std::tie(s.first); }
};

/// The upper turns at a point; see sample_light_tree(). The tree must have lights.
template <class L>
SHEAF_INLINE LightTreeTop<L> light_tree_top(const LightTreeView& tree, Vec3<L> p, Vec3<L> n, Mask<L> has_normal) {
  using namespace light_tree_detail;
  using F = Float<L>;
  const Receiver<L> at = make_receiver<L>(p, n, has_normal);
  LightTreeTop<L> top;
  for (int pair = 0; pair < kLightTopPairs; ++pair) {
    const std::uint32_t link = tree.top[pair];
    top.first[pair] = F(LightTreeTop<L>::kAlwaysFirst);
    if ((link & kLightLeaf) != 0) continue;
    const LightNodeRow* const rows = tree.nodes + (link & kLightIndex);
    const Turn<L> way = turn<L>({broadcast<L>(rows[0]), broadcast<L>(rows[1])}, at);
    const F sum = way.sum();
    const auto possible = sum > F(0.0f);
    top.first[pair] = select(possible, way.first / select(possible, sum, F(1.0f)), F(LightTreeTop<L>::kNoTurn));
  }
  return top;
}

/// Draws what sample_light_tree() draws for the same point, of which `top` was made, to rounding.
template <class L>
SHEAF_INLINE LightTreeSample<L> sample_light_tree(const LightTreeView& tree, const LightTreeTop<L>& top, Vec3<L> p,
                                                  Vec3<L> n, Mask<L> has_normal, typename L::Float u) {
  using namespace light_tree_detail;
  using F = Float<L>;
  using U = Uint<L>;
  Descent<L> way = Descent<L>::at_root(u);
  U node(0u);
  Mask<L> turns[kLightTopLevels];
  for (int level = 0; level < kLightTopLevels; ++level) {
    // The pair that the turns so far lead to, of 2^level.
    F candidates[1 << (kLightTopLevels - 1)];
    const int count = 1 << level;
    for (int k = 0; k < count; ++k) candidates[k] = top.first[count - 1 + k];
    for (int bit = 0; bit < level; ++bit)
      for (int k = 0; k < count >> (bit + 1); ++k)
        candidates[k] = select(turns[bit], candidates[k], candidates[k + (count >> (bit + 1))]);
    const F first = candidates[0], one(1.0f), zero(0.0f);
    const auto known = (first >= zero) & (first <= one);
    turns[level] =
        way.take({select(known, first, zero), select(known, one - first, zero)}, first <= one) | (first > one);
    node = (node << 1) + select(turns[level], U(1u), U(2u));
  }
  return descend<L>(tree, make_receiver<L>(p, n, has_normal), way, gather(tree.top, node));
}

/// The probability with which sample_light_tree() draws `light` for the same point and normal; 0 in lanes that are not
/// `active`, whose `light` may be anything.
template <class L>
SHEAF_INLINE Float<L> light_tree_probability(const LightTreeView& tree, Vec3<L> p, Vec3<L> n, Mask<L> has_normal,
                                             typename L::Uint light, Mask<L> active) {
  using namespace light_tree_detail;
  using F = Float<L>;
  using U = Uint<L>;
  if (tree.node_count == 0) return F(0.0f);
  const Receiver<L> at = make_receiver<L>(p, n, has_normal);
  U trail = gather(tree.trails, select(active, light, U(0u)));
  U node(0u);
  F chosen = select(active, F(1.0f), F(0.0f)), offered(1.0f);
  while (any(active)) {
    const NodePair<L> pair = load_pair<L>(tree, node);
    const Turn<L> way = turn<L>(pair, at);
    const auto goes_first = (trail & U(1u)) == U(0u);
    const F sum = way.sum(), scale = reciprocal_power_of_two<L>(sum);
    chosen = select(active, chosen * (select(goes_first, way.first, way.second) * scale), chosen);
    offered = select(active, offered * (sum * scale), offered);
    const U link = select(goes_first, pair.first.link, pair.second.link);
    active = active & ((link & U(kLightLeaf)) == U(0u)) & (chosen > F(0.0f));
    trail = trail >> 1;
    node = select(active, link & U(kLightIndex), U(0u));
  }
  return select(chosen > F(0.0f), chosen / offered, F(0.0f));
}

}  // namespace sheaf
