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
  typename L::Uint light;         ///< its index; 0 unless valid
  typename L::Float probability;  ///< that it is drawn; 0 unless valid
  typename L::Float remapped;     ///< a fresh uniform number in [0, 1) from what is left of u
  typename L::Mask valid;         ///< false: no light can shine here, or the tree is empty
};

namespace light_tree_detail {

/// The least cosine that a light in view is given at either end: what single precision takes for grazing may not be.
inline constexpr float kMinCosine = 1e-3f;
/// Where several children may contribute, each is drawn with at least this probability. Uniform numbers of 24 bits can
/// still choose it, and products over many levels do not underflow.
inline constexpr float kMinTurn = 0x1p-20f;
/// How far a draw may go into what there is to draw from.
inline constexpr float kFarthest = 1.0f - 0x1p-22f;
/// Squared distances are kept in this range, which keeps their products finite.
inline constexpr float kNearSquared = 1e-18f, kFarSquared = 1e18f;

/// Where light is wanted.
template <class L> struct Receiver {
  Vec3<L> p;
  Vec3<L> n;                ///< unit length, or zero
  typename L::Float least;  ///< cosine that is added: 1 where there is no normal, else kMinCosine
};

template <class L> SHEAF_INLINE Receiver<L> make_receiver(Vec3<L> p, Vec3<L> n, Mask<L> has_normal) {
  const Mask<L> facing = has_normal & (dot(n, n) > Float<L>(0.0f));
  const Float<L> zero(0.0f);
  return {p, select(facing, n, Vec3<L>{zero, zero, zero}), select(facing, Float<L>(kMinCosine), Float<L>(1.0f))};
}

/// The power of two which brings a positive x to [1, 2). A division would take longer.
template <class L> SHEAF_INLINE Float<L> reciprocal_power_of_two(typename L::Float x) {
  using U = Uint<L>;
  return bits_float(U(0x7f000000u) - (float_bits(x) & U(0x7f800000u)));
}

/// A node in registers, as its words, whose middle is told from the receiver.
template <class L> struct NodeWords {
  typename L::Float words[LightNodeRow::kWordCount];

  SHEAF_INLINE void move_to(const Receiver<L>& at) {
    words[LightNodeRow::kMiddle] = words[LightNodeRow::kMiddle] - at.p.x;
    words[LightNodeRow::kMiddle + 1] = words[LightNodeRow::kMiddle + 1] - at.p.y;
    words[LightNodeRow::kMiddle + 2] = words[LightNodeRow::kMiddle + 2] - at.p.z;
  }
  SHEAF_INLINE Uint<L> link() const { return float_bits(words[LightNodeRow::kLink]); }
};

template <class L>
SHEAF_INLINE NodeWords<L> load_node(const LightTreeView& tree, typename L::Uint index, const Receiver<L>& at) {
  alignas(kSimdAlignment) std::uint32_t lanes[L::width];
  store(lanes, index);
  const float* rows[L::width];
  for (int lane = 0; lane < L::width; ++lane)
    rows[lane] = reinterpret_cast<const float*>(tree.nodes[lanes[lane]].words);
  NodeWords<L> node;
  for (int k = 0; k < LightNodeRow::kWordCount; k += 4) {
    load_rows4(rows, node.words + k);
    for (int lane = 0; lane < L::width; ++lane) rows[lane] += 4;
  }
  node.move_to(at);
  return node;
}

/// The same node in all lanes.
template <class L> SHEAF_INLINE NodeWords<L> broadcast(const LightNodeRow& row, const Receiver<L>& at) {
  NodeWords<L> node;
  for (int k = 0; k < LightNodeRow::kWordCount; ++k) node.words[k] = Float<L>(bits_float(row.words[k]));
  node.move_to(at);
  return node;
}

/// 1 / sqrt(x) for positive x that is far from the ends of the range, with an error below 1.7e-5 of it; the same in all
/// lanes. A guess g by the exponent times a polynomial in x g^2, the one with the least error in the worst place. A
/// square root and a division would take longer, and so would two of Newton's steps.
template <class L> SHEAF_INLINE Float<L> inverse_sqrt(typename L::Float x) {
  using F = Float<L>;
  const F guess = bits_float(Uint<L>(0x5f200000u) - (float_bits(x) >> 1)), r = x * guess * guess;
  return guess * fma(fma(F(0.6630861f), r, F(-1.76082021f)), r, F(2.10231116f));
}

/// What a child may contribute.
template <class L> struct Importance {
  typename L::Float weight;  ///< 0 unless it shines
  Mask<L> shines;            ///< whether it may contribute at all
};

/// Bounds of cosines instead of the largest ones: for a sphere of radius r around a point at distance D, under an angle
/// i, no direction to it has a larger cosine than cos i + r / D, as cos(i - b) <= cos i + sin b; and the same with the
/// cone of normals at the other end, where the sine of the angle w from its axis is at most 1 - (cos w)^2 / 2.
/// `child.center`: from the receiver.
template <class L> SHEAF_INLINE Importance<L> importance(const LightChild<L>& child, const Receiver<L>& at) {
  using F = Float<L>;
  const Vec3<L> d = child.center;
  const F squared = clamp(dot(d, d), F(kNearSquared), F(kFarSquared)), inverse = inverse_sqrt<L>(squared);
  const F one(1.0f), least(kMinCosine);
  // At the light; two sides have two axes.
  const F cos_w = bits_float(float_bits(dot(child.tilt, d) * (inverse * F(1.0f / kLightFixedPoint))) & child.keep_sign);
  const F sin_w = fma(cos_w * F(-0.5f), cos_w, one);
  const F cos_light = fma(child.radius, inverse, fma(child.spread, sin_w, cos_w));
  // At the receiver, on the side of its normal where the light is.
  const F cos_receiver = fma(abs(dot(at.n, d)) + child.radius, inverse, at.least);
  // Distances count as the radius at least, of which the inverse need not be exact: 1 / r to a twentieth, up to 1e10.
  using U = Uint<L>;
  const F nearest = min(inverse, bits_float(U(0x7ef311c7u) - min(float_bits(child.radius), U(0x501502f9u))));
  const F weight = child.share * (nearest * nearest) * (clamp(cos_light, least, one) * min(cos_receiver, one));
  const auto shines = cos_light + child.reach > one;
  return {select(shines, weight, F(0.0f)), shines};
}

/// The ways on from a node, as weights of which only the ratio counts.
template <class L> struct Turn {
  typename L::Float weights[kLightChildren];

  SHEAF_INLINE Float<L> sum() const { return (weights[0] + weights[1]) + (weights[2] + weights[3]); }
};

template <class L> SHEAF_INLINE Turn<L> turn(const NodeWords<L>& node, const Receiver<L>& at) {
  using F = Float<L>;
  const Importance<L> children[kLightChildren] = {
      importance<L>(unpack_light_child<L, 0>(node.words), at), importance<L>(unpack_light_child<L, 1>(node.words), at),
      importance<L>(unpack_light_child<L, 2>(node.words), at), importance<L>(unpack_light_child<L, 3>(node.words), at)};
  const F least = ((children[0].weight + children[1].weight) + (children[2].weight + children[3].weight)) * F(kMinTurn);
  Turn<L> way;
  for (int k = 0; k < kLightChildren; ++k)
    way.weights[k] = select(children[k].shines, max(children[k].weight, least), F(0.0f));
  return way;
}

/// values[child], which is below 4.
template <class L> SHEAF_INLINE Float<L> pick(const typename L::Float* values, typename L::Uint child) {
  using U = Uint<L>;
  const auto is_odd = (child & U(1u)) != U(0u), is_upper = (child & U(2u)) != U(0u);
  return select(is_upper, select(is_odd, values[3], values[2]), select(is_odd, values[1], values[0]));
}

/// The place of a child of node `index`; see light_tree_child().
template <class L>
SHEAF_INLINE Uint<L> place_of_child(const NodeWords<L>& node, typename L::Uint index, typename L::Uint child) {
  using U = Uint<L>;
  const U link = node.link();
  return select(child < (link >> kLightNodeBits), (link & U(kLightNodeIndex)) + child,
                U(kLightLeaf) | (index << 2) | child);
}

/// Where a draw stands: `rest` / `whole` of the node's share of u lies before it, and `chosen` / `offered` is the
/// probability of having come here. No division until the end: a walk waits for each of its steps.
template <class L> struct Descent {
  typename L::Float rest, whole, chosen, offered;

  static SHEAF_INLINE Descent at_root(typename L::Float u) {
    return {u, Float<L>(1.0f), Float<L>(1.0f), Float<L>(1.0f)};
  }
  SHEAF_INLINE Mask<L> possible() const { return chosen > Float<L>(0.0f); }

  /// Takes a turn; to which child.
  SHEAF_INLINE Uint<L> take(const Turn<L>& way, Mask<L> active) {
    using F = Float<L>;
    using U = Uint<L>;
    const auto& w = way.weights;
    const F sum = way.sum(), first = w[0], two = first + w[1], three = two + w[2];
    const F borders[3] = {whole * first, whole * two, whole * three};
    // Before the end, whatever the rounding: so a child without weight is always passed over for a later one.
    const F here = min(rest, whole * F(kFarthest)) * sum;
    F border(0.0f), taken = first;
    U child(0u);
    for (std::uint32_t k = 1; k < kLightChildren; ++k) {
      const auto beyond = here >= borders[k - 1];
      border = select(beyond, borders[k - 1], border);
      taken = select(beyond, w[k], taken);
      child = select(beyond, U(k), child);
    }
    const F part = whole * taken;
    const F scale = reciprocal_power_of_two<L>(part), scale_sum = reciprocal_power_of_two<L>(sum);
    rest = select(active, (here - border) * scale, rest);
    whole = select(active, part * scale, whole);
    chosen = select(active, chosen * (taken * scale_sum), chosen);
    offered = select(active, offered * (sum * scale_sum), offered);
    return child;
  }
};

}  // namespace light_tree_detail

/// A draw that is on its way down a light tree; see end_light_walks().
template <class L> struct LightTreeWalk {
  light_tree_detail::Receiver<L> at;
  light_tree_detail::Descent<L> way;
  typename L::Uint place;  ///< where it stands
};

/// Walks to the ends, all of them together: a walk waits for each of its steps, and meanwhile the others go on. The
/// tree must have lights.
template <class L, int N>
SHEAF_INLINE void end_light_walks(const LightTreeView& tree, LightTreeWalk<L> (&walks)[N],
                                  LightTreeSample<L> (&samples)[N]) {
  using namespace light_tree_detail;
  using F = Float<L>;
  using U = Uint<L>;
  const auto goes_on = [](const LightTreeWalk<L>& walk) SHEAF_LAMBDA_INLINE {
    return ((walk.place & U(kLightLeaf)) == U(0u)) & walk.way.possible();
  };
  Mask<L> active[N];
  const auto goes_any_on = [&]() SHEAF_LAMBDA_INLINE {
    for (int i = 0; i < N; ++i) active[i] = goes_on(walks[i]);
    Mask<L> all = active[0];
    for (int i = 1; i < N; ++i) all = all | active[i];
    return any(all);
  };
  while (goes_any_on()) {
    for (int i = 0; i < N; ++i) {
      LightTreeWalk<L>& walk = walks[i];
      const U index = select(active[i], walk.place, U(0u));
      const NodeWords<L> node = load_node<L>(tree, index, walk.at);
      const U child = walk.way.take(turn<L>(node, walk.at), active[i]);
      walk.place = select(active[i], place_of_child<L>(node, index, child), walk.place);
    }
  }
  constexpr std::uint32_t kRowWords = sizeof(LightNodeRow) / sizeof(std::uint32_t);
  for (int i = 0; i < N; ++i) {
    const Descent<L>& way = walks[i].way;
    const auto valid = way.possible();
    const F remapped = clamp(way.rest / select(valid, way.whole, F(1.0f)), F(0.0f), F(kOneMinusEpsilon));
    const U leaf = select(valid, walks[i].place & U(~kLightLeaf), U(0u));
    const U light = gather(tree.nodes->lights, (leaf >> 2) * U(kRowWords) + (leaf & U(3u)));
    samples[i] = {select(valid, light, U(0u)), select(valid, way.chosen / way.offered, F(0.0f)), remapped, valid};
  }
}

/// Begins the draw of sample_light_tree().
template <class L>
SHEAF_INLINE LightTreeWalk<L> begin_light_walk(Vec3<L> p, Vec3<L> n, Mask<L> has_normal, typename L::Float u) {
  using namespace light_tree_detail;
  return {make_receiver<L>(p, n, has_normal), Descent<L>::at_root(u), Uint<L>(0u)};
}

/// Draws a light for the point `p` by `u` in [0, 1). `n`: unit normal for shading; light on either side of it counts.
/// A zero `n` or `has_normal` false stands for a point in a medium. Every light that can shine on `p` has a positive
/// probability. u keeps about 24 - log2(1 / probability) random bits: lights much rarer than 2^-24 share them.
template <class L>
SHEAF_INLINE LightTreeSample<L> sample_light_tree(const LightTreeView& tree, Vec3<L> p, Vec3<L> n, Mask<L> has_normal,
                                                  typename L::Float u) {
  if (tree.node_count == 0) return {Uint<L>(0u), Float<L>(0.0f), u, Mask<L>(false)};
  LightTreeWalk<L> walk[1] = {begin_light_walk<L>(p, n, has_normal, u)};
  LightTreeSample<L> sample[1];
  end_light_walks<L>(tree, walk, sample);
  return sample[0];
}

/// The upper turns for one receiver, which all its candidates have in common.
template <class L> struct LightTreeCut {
  /// For each upper node the probabilities that its child is one of the first one, two and three. kAlwaysFirst where
  /// there is no node, as a leaf lies above it, and kNoTurn where none of its lights can contribute.
  typename L::Float below[(kLightChildren - 1) * kLightTopTurns];

  static constexpr float kAlwaysFirst = 2, kNoTurn = -1;
  static constexpr auto fields(auto& s) { return std::tie(s.below); }
};

/// The upper turns at a point; see sample_light_tree(). The tree must have lights.
template <class L>
SHEAF_INLINE LightTreeCut<L> light_tree_top(const LightTreeView& tree, Vec3<L> p, Vec3<L> n, Mask<L> has_normal) {
  using namespace light_tree_detail;
  using F = Float<L>;
  const Receiver<L> at = make_receiver<L>(p, n, has_normal);
  LightTreeCut<L> top;
  for (int node = 0; node < kLightTopTurns; ++node) {
    F* const below = top.below + (kLightChildren - 1) * node;
    for (int k = 0; k + 1 < kLightChildren; ++k) below[k] = F(LightTreeCut<L>::kAlwaysFirst);
    const std::uint32_t place = tree.top[node];
    if ((place & kLightLeaf) != 0) continue;
    const Turn<L> way = turn<L>(broadcast<L>(tree.nodes[place], at), at);
    const F sum = way.sum();
    const auto possible = sum > F(0.0f);
    const F inverse = F(1.0f) / select(possible, sum, F(1.0f));
    F before(0.0f);
    for (int k = 0; k + 1 < kLightChildren; ++k) {
      before = before + way.weights[k];
      below[k] = select(possible, min(before * inverse, F(1.0f)), F(LightTreeCut<L>::kNoTurn));
    }
  }
  return top;
}

/// The same as without `top`, to rounding, which was made of the same point.
template <class L>
SHEAF_INLINE LightTreeWalk<L> begin_light_walk(const LightTreeView& tree, const LightTreeCut<L>& top, Vec3<L> p,
                                               Vec3<L> n, Mask<L> has_normal, typename L::Float u) {
  using namespace light_tree_detail;
  using F = Float<L>;
  using U = Uint<L>;
  static_assert(kLightTopLevels == 2);
  constexpr int kBorders = kLightChildren - 1;
  const F zero(0.0f), one(1.0f);
  Descent<L> way = Descent<L>::at_root(u);
  const auto take = [&](const F* below) SHEAF_LAMBDA_INLINE {
    const auto known = (below[0] >= zero) & (below[0] <= one);
    const Turn<L> turn{{select(known, below[0], zero), select(known, below[1] - below[0], zero),
                        select(known, below[2] - below[1], zero), select(known, one - below[2], zero)}};
    return select(below[0] > one, U(0u), way.take(turn, below[0] <= one));
  };
  const U first = take(top.below);
  F below[kBorders];
  for (int k = 0; k < kBorders; ++k) {
    const F of_children[kLightChildren] = {top.below[kBorders + k], top.below[2 * kBorders + k],
                                           top.below[3 * kBorders + k], top.below[4 * kBorders + k]};
    below[k] = pick<L>(of_children, first);
  }
  const U second = take(below);
  const U place = gather(tree.top, (first << 2) + second + U(kLightTopTurns));
  return {make_receiver<L>(p, n, has_normal), way, place};
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
  U index(0u);
  F chosen = select(active, F(1.0f), F(0.0f)), offered(1.0f);
  while (any(active)) {
    const NodeWords<L> node = load_node<L>(tree, index, at);
    const Turn<L> way = turn<L>(node, at);
    const U child = trail & U(3u);
    const F sum = way.sum(), scale = reciprocal_power_of_two<L>(sum);
    chosen = select(active, chosen * (pick<L>(way.weights, child) * scale), chosen);
    offered = select(active, offered * (sum * scale), offered);
    const U place = place_of_child<L>(node, index, child);
    active = active & ((place & U(kLightLeaf)) == U(0u)) & (chosen > F(0.0f));
    trail = trail >> 2;
    index = select(active, place, U(0u));
  }
  return select(chosen > F(0.0f), chosen / offered, F(0.0f));
}

}  // namespace sheaf
