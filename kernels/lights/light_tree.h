// Picks a light at random from a light tree, in proportion to what its part of the tree may contribute at a point, and
// tells the probability with which it would pick a given one.
//
// The measure of importance is that of Pharr et al., "Physically Based Rendering", 4th ed., section 12.6.3, after Conty
// Estevez and Kulla (HPG 2018), equation 3: power, over squared distance, times the largest cosines that any light of
// the node can have at either end. All angles stay cosines and sines, times the distance: no arc functions, and
// differences of angles are compared with zero by the sign of their sine.
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
  Vec3<L> n;                ///< unit length
  typename L::Mask facing;  ///< whether `n` means anything
};

template <class L> SHEAF_INLINE Receiver<L> make_receiver(Vec3<L> p, Vec3<L> n, Mask<L> has_normal) {
  const Mask<L> facing = has_normal & (dot(n, n) > Float<L>(0.0f));
  return {p, n, facing};
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
  typename L::Float words[2][kWords];
  for (auto& child : words)
    for (int k = 0; k < kRowWords; k += 4) {
      if (k < kWords) load_rows4(rows, child + k);
      for (int lane = 0; lane < L::width; ++lane) rows[lane] += 4;
    }
  return {record_of_words<L, LightNode>(words[0]), record_of_words<L, LightNode>(words[1])};
}

/// The same node in all lanes.
template <class L> SHEAF_INLINE LightNode<L> broadcast(const LightNodeRow& row) {
  using F = Float<L>;
  return {{F(row.center.x), F(row.center.y), F(row.center.z)},
          F(row.radius),
          {F(row.axis.x), F(row.axis.y), F(row.axis.z)},
          F(row.share),
          F(row.cos_theta_o),
          F(row.sin_theta_o),
          F(row.cos_theta_e),
          Uint<L>(row.link)};
}

template <class L> SHEAF_INLINE Importance<L> importance(const LightNode<L>& node, const Receiver<L>& at) {
  using F = Float<L>;
  using U = Uint<L>;
  const F zero(0.0f), radius = node.radius;
  const Vec3<L> d = node.center - at.p;
  const F squared = clamp(dot(d, d), F(kNearSquared), F(kFarSquared));
  const F radius_squared = radius * radius;
  const auto inside = squared <= max(radius_squared, F(kNearSquared));
  // The angle b under which the sphere around the lights is seen: cosine, sine x distance = to_edge, radius.
  const F to_edge = safe_sqrt(squared - radius_squared);

  // At the light: the angle w from the axis, less that of the cone, less b.
  const U keep_sign = U(0xffffffffu) ^ ((node.link & U(kLightTwoSided)) << 1);
  const F cos_w = bits_float(float_bits(-dot(node.axis, d)) & keep_sign);
  const F sin_w = safe_sqrt(fma(-cos_w, cos_w, squared));
  const F cos_x = fma(cos_w, node.cos_theta_o, sin_w * node.sin_theta_o),
          sin_x = fma(sin_w, node.cos_theta_o, -(cos_w * node.sin_theta_o));
  const auto in_cone = inside | (sin_x <= zero) | (sin_x * to_edge <= cos_x * radius);
  const F cos_light = select(in_cone, squared, fma(cos_x, to_edge, sin_x * radius));

  // At the receiver: the angle i from the normal, on the side where the light is, less b.
  const F cos_i = abs(dot(at.n, d)), sin_i = safe_sqrt(fma(-cos_i, cos_i, squared));
  const auto overhead = inside | (!at.facing) | (sin_i * to_edge <= cos_i * radius);
  const F cos_receiver = select(overhead, squared, fma(cos_i, to_edge, sin_i * radius));

  // Both cosines are times the squared distance here. A power of two close to its inverse brings them near 1: a
  // division would take longer, and squares of the distance might not be finite.
  const F scale = bits_float(U(0x7f000000u) - (float_bits(squared) & U(0x7f800000u)));
  const F one = squared * scale, least = one * F(kLeastCosine);
  const F weight = node.share * max(cos_light * scale, least) * max(cos_receiver * scale, least);
  return {select(cos_light > node.cos_theta_e * squared, weight, zero),
          one * one * min(max(squared, radius_squared), F(kFarSquared))};
}

/// The way on from a node.
template <class L> struct Turn {
  typename L::Float first, second;  ///< probabilities of the children
  typename L::Mask possible;        ///< whether any light below may contribute
};

template <class L> SHEAF_INLINE Turn<L> turn(const NodePair<L>& pair, const Receiver<L>& at) {
  using F = Float<L>;
  const F zero(0.0f), one(1.0f);
  const Importance<L> a = importance<L>(pair.first, at), b = importance<L>(pair.second, at);
  const F to_first = a.weight * b.divisor, to_second = b.weight * a.divisor;
  const F sum = to_first + to_second;
  const auto possible = sum > zero;
  const F least = select(to_first > zero, F(kLeastTurn), zero);
  const F most = select(to_second > zero, F(1.0f - kLeastTurn), one);
  const F first = min(max(to_first / select(possible, sum, one), least), most);
  return {first, one - first, possible};
}

/// Where a draw stands: u lies in [begin, begin + width), and width is the probability of having come here.
template <class L> struct Descent {
  typename L::Float begin, width;

  /// Takes a turn; whether it leads to the first child.
  SHEAF_INLINE Mask<L> take(const Turn<L>& way, Mask<L> active, Float<L> u) {
    const Float<L> border = fma(width, way.first, begin);
    const auto goes_first = u < border;
    const Float<L> taken = select(way.possible, select(goes_first, way.first, way.second), Float<L>(0.0f));
    begin = select(active & !goes_first, border, begin);
    width = select(active, width * taken, width);
    return goes_first;
  }
};

/// Goes on from `node` in the lanes of `active`, to a leaf, whose link is kept in `link`.
template <class L>
SHEAF_INLINE LightTreeSample<L> descend(const LightTreeView& tree, const Receiver<L>& at, typename L::Float u,
                                        Descent<L> way, typename L::Uint link) {
  using F = Float<L>;
  using U = Uint<L>;
  auto active = ((link & U(kLightLeaf)) == U(0u)) & (way.width > F(0.0f));
  while (any(active)) {
    const NodePair<L> pair = load_pair<L>(tree, select(active, link & U(kLightIndex), U(0u)));
    const auto goes_first = way.take(turn<L>(pair, at), active, u);
    link = select(active, select(goes_first, pair.first.link, pair.second.link), link);
    active = active & ((link & U(kLightLeaf)) == U(0u)) & (way.width > F(0.0f));
  }
  const auto valid = way.width > F(0.0f);
  const F remapped = clamp((u - way.begin) / select(valid, way.width, F(1.0f)), F(0.0f), F(kOneMinusEpsilon));
  return {select(valid, link & U(kLightIndex), U(0u)), way.width, remapped, valid};
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
  return descend<L>(tree, make_receiver<L>(p, n, has_normal), u, {F(0.0f), F(1.0f)}, Uint<L>(0u));
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
    top.first[pair] = select(way.possible, way.first, F(LightTreeTop<L>::kNoTurn));
  }
  return top;
}

/// Draws what sample_light_tree() draws for the same point, of which `top` was made.
template <class L>
SHEAF_INLINE LightTreeSample<L> sample_light_tree(const LightTreeView& tree, const LightTreeTop<L>& top, Vec3<L> p,
                                                  Vec3<L> n, Mask<L> has_normal, typename L::Float u) {
  using namespace light_tree_detail;
  using F = Float<L>;
  using U = Uint<L>;
  Descent<L> way{F(0.0f), F(1.0f)};
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
    const F first = candidates[0];
    const F in_range = min(max(first, F(0.0f)), F(1.0f));
    turns[level] = way.take({in_range, F(1.0f) - in_range, first >= F(0.0f)}, first <= F(1.0f), u) | (first > F(1.0f));
    node = (node << 1) + select(turns[level], U(1u), U(2u));
  }
  return descend<L>(tree, make_receiver<L>(p, n, has_normal), u, way, gather(tree.top, node));
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
  F probability = select(active, F(1.0f), F(0.0f));
  while (any(active)) {
    const NodePair<L> pair = load_pair<L>(tree, node);
    const Turn<L> way = turn<L>(pair, at);
    const auto goes_first = (trail & U(1u)) == U(0u);
    const F taken = select(way.possible, select(goes_first, way.first, way.second), F(0.0f));
    probability = select(active, probability * taken, probability);
    const U link = select(goes_first, pair.first.link, pair.second.link);
    active = active & ((link & U(kLightLeaf)) == U(0u)) & (probability > F(0.0f));
    trail = trail >> 1;
    node = select(active, link & U(kLightIndex), U(0u));
  }
  return probability;
}

}  // namespace sheaf
