// Sampling of a light tree: chooses a light in proportion to the estimated contribution of its subtree at a point, and
// computes the probability of choosing a given light.
//
// The importance measure is that of Pharr et al., "Physically Based Rendering", 4th ed., section 12.6.3, after Conty
// Estevez and Kulla (HPG 2018), equation 3: power over squared distance, times the maximum cosines at the light and at
// the receiver over all lights of a node. Slightly larger bounds replace these cosines where they are cheaper to
// compute.
#pragma once

#include "scene/tables/light_tree.h"

#include "core/math/inverse_sqrt.h"
#include "core/soa/lane_array.h"

namespace sheaf {

/// A light sampled from a light tree.
template <class L> struct LightTreeSample {
  typename L::Uint light;         ///< its index; 0 unless valid
  typename L::Float probability;  ///< of sampling it; 0 unless valid
  typename L::Float remapped;     ///< remainder of u, rescaled to a uniform number in [0, 1)
  typename L::Mask valid;         ///< false: no light can reach the point, or the tree is empty
};

namespace light_tree_detail {

/// Minimum cosine assumed at either end for a light that may be visible, since rounding may make an angle appear
/// grazing.
inline constexpr float kMinCosine = 1e-3f;
/// Minimum probability of each child that may contribute, if several do. A uniform number with 24 bits can still select
/// it, and products over many levels do not underflow.
inline constexpr float kMinTurn = 0x1p-20f;
/// Largest random number used for the selection.
inline constexpr float kFarthest = 1.0f - 0x1p-22f;
/// Squared distances are clamped to this range, which keeps their products finite.
inline constexpr float kNearSquared = 1e-18f, kFarSquared = 1e18f;

/// The point to be lit.
template <class L> struct Receiver {
  Vec3<L> p;
  Vec3<L> n;                      ///< unit length, or zero
  typename L::Float cosine_bias;  ///< added to the cosine: 1 without a normal, else kMinCosine
};

template <class L> SHEAF_INLINE Receiver<L> make_receiver(Vec3<L> p, Vec3<L> n, Mask<L> has_normal) {
  const Mask<L> facing = has_normal & (dot(n, n) > Float<L>(0.0f));
  const Float<L> zero(0.0f);
  return {p, select(facing, n, Vec3<L>{zero, zero, zero}), select(facing, Float<L>(kMinCosine), Float<L>(1.0f))};
}

/// The power of two that scales a positive x to [1, 2). Faster than a division.
template <class L> SHEAF_INLINE Float<L> reciprocal_power_of_two(typename L::Float x) {
  using U = Uint<L>;
  return bits_float(U(0x7f000000u) - (float_bits(x) & U(0x7f800000u)));
}

/// A node in registers, as its words. The centre of its bounds is relative to the receiver.
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
  RowPointers<L> rows(tree.nodes, index);
  NodeWords<L> node;
  for (int k = 0; k < LightNodeRow::kWordCount; k += 4) rows.read_four(node.words + k);
  node.move_to(at);
  return node;
}

/// Loads the same node into all lanes.
template <class L> SHEAF_INLINE NodeWords<L> broadcast(const LightNodeRow& row, const Receiver<L>& at) {
  NodeWords<L> node;
  for (int k = 0; k < LightNodeRow::kWordCount; ++k) node.words[k] = Float<L>(bits_float(row.words[k]));
  node.move_to(at);
  return node;
}

/// Estimated contribution of a child.
template <class L> struct Importance {
  typename L::Float weight;  ///< 0 unless `shines`
  Mask<L> shines;            ///< the child may contribute
};

/// Uses bounds on the cosines instead of their maxima. For a sphere of radius r whose centre is at distance D and at
/// the angle i, no direction to the sphere has a larger cosine than cos i + r / D, because cos(i - b) <= cos i + sin b.
/// The same holds for the cone of normals at the light, where the sine of the angle w from its axis is at most
/// 1 - (cos w)^2 / 2. `child.center` is relative to the receiver.
template <class L> SHEAF_INLINE Importance<L> importance(const LightChild<L>& child, const Receiver<L>& at) {
  using F = Float<L>;
  const Vec3<L> d = child.center;
  const F squared = clamp(dot(d, d), F(kNearSquared), F(kFarSquared)), inverse = rough_inverse_sqrt<L>(squared);
  const F one(1.0f), min_cosine(kMinCosine);
  // Cosine at the light. Two-sided lights have two axes.
  const F cos_w = bits_float(float_bits(dot(child.tilt, d) * (inverse * F(1.0f / kLightFixedPoint))) & child.keep_sign);
  const F sin_w = fma(cos_w * F(-0.5f), cos_w, one);
  const F cos_light = fma(child.radius, inverse, fma(child.spread, sin_w, cos_w));
  // Cosine at the receiver, on the side of its normal where the light is.
  const F cos_receiver = fma(abs(dot(at.n, d)) + child.radius, inverse, at.cosine_bias);
  // The distance counts as at least the radius. Its inverse is approximated to within 1/20, for radii up to 1e10.
  using U = Uint<L>;
  const F nearest = min(inverse, bits_float(U(0x7ef311c7u) - min(float_bits(child.radius), U(0x501502f9u))));
  const F weight = child.share * (nearest * nearest) * (clamp(cos_light, min_cosine, one) * min(cos_receiver, one));
  const auto shines = cos_light + child.reach > one;
  return {select(shines, weight, F(0.0f)), shines};
}

/// Relative weights of the children of a node.
template <class L> struct Turn {
  typename L::Float weights[kLightChildren];

  SHEAF_INLINE Float<L> sum() const { return (weights[0] + weights[1]) + (weights[2] + weights[3]); }
};

template <class L> SHEAF_INLINE Turn<L> turn(const NodeWords<L>& node, const Receiver<L>& at) {
  using F = Float<L>;
  const Importance<L> children[kLightChildren] = {
      importance<L>(unpack_light_child<L, 0>(node.words), at), importance<L>(unpack_light_child<L, 1>(node.words), at),
      importance<L>(unpack_light_child<L, 2>(node.words), at), importance<L>(unpack_light_child<L, 3>(node.words), at)};
  const F min_weight =
      ((children[0].weight + children[1].weight) + (children[2].weight + children[3].weight)) * F(kMinTurn);
  Turn<L> way;
  for (int k = 0; k < kLightChildren; ++k)
    way.weights[k] = select(children[k].shines, max(children[k].weight, min_weight), F(0.0f));
  return way;
}

/// values[child] for child < 4.
template <class L> SHEAF_INLINE Float<L> pick(const typename L::Float* values, typename L::Uint child) {
  using U = Uint<L>;
  const auto is_odd = (child & U(1u)) != U(0u), is_upper = (child & U(2u)) != U(0u);
  return select(is_upper, select(is_odd, values[3], values[2]), select(is_odd, values[1], values[0]));
}

/// Place of a child of node `index`: see light_tree_child().
template <class L>
SHEAF_INLINE Uint<L> place_of_child(const NodeWords<L>& node, typename L::Uint index, typename L::Uint child) {
  using U = Uint<L>;
  const U link = node.link();
  return select(child < (link >> kLightNodeBits), (link & U(kLightNodeIndex)) + child,
                U(kLightLeaf) | (index << 2) | child);
}

/// State of a descent. `rest` / `whole` is the remaining random number in [0, 1), and `chosen` / `offered` the
/// probability of reaching the current node. Both stay fractions until the end, because a division would add latency to
/// each step.
template <class L> struct Descent {
  typename L::Float rest, whole, chosen, offered;

  static SHEAF_INLINE Descent at_root(typename L::Float u) {
    return {u, Float<L>(1.0f), Float<L>(1.0f), Float<L>(1.0f)};
  }
  SHEAF_INLINE Mask<L> possible() const { return chosen > Float<L>(0.0f); }

  /// Selects a child and returns its index; updates the `active` lanes.
  SHEAF_INLINE Uint<L> take(const Turn<L>& way, Mask<L> active) {
    using F = Float<L>;
    using U = Uint<L>;
    const auto& w = way.weights;
    const F sum = way.sum(), first = w[0], two = first + w[1], three = two + w[2];
    const F borders[3] = {whole * first, whole * two, whole * three};
    // Keep the number below the upper end despite rounding, so that children of weight 0 are never selected.
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

/// A descent through a light tree that is under way; see end_light_walks().
template <class L> struct LightTreeWalk {
  light_tree_detail::Receiver<L> at;
  light_tree_detail::Descent<L> way;
  typename L::Uint place;  ///< current place in the tree
};

/// Completes all descents, interleaved to hide their latency: each step depends on the one before. The tree must have
/// lights.
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
  // Descend by one level at a time.
  while (goes_any_on()) {
    for (int i = 0; i < N; ++i) {
      LightTreeWalk<L>& walk = walks[i];
      const U index = select(active[i], walk.place, U(0u));
      const NodeWords<L> node = load_node<L>(tree, index, walk.at);
      const U child = walk.way.take(turn<L>(node, walk.at), active[i]);
      walk.place = select(active[i], place_of_child<L>(node, index, child), walk.place);
    }
  }
  // Read the lights at the leaves.
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

/// Begins the descent of sample_light_tree().
template <class L>
SHEAF_INLINE LightTreeWalk<L> begin_light_walk(Vec3<L> p, Vec3<L> n, Mask<L> has_normal, typename L::Float u) {
  using namespace light_tree_detail;
  return {make_receiver<L>(p, n, has_normal), Descent<L>::at_root(u), Uint<L>(0u)};
}

/// Samples a light for the point `p` by `u` in [0, 1). `n`: unit shading normal; light on either side of it counts. A
/// zero `n`, or `has_normal` false, stands for a point in a medium. Every light that can reach `p` has a positive
/// probability. About 24 - log2(1 / probability) random bits of u remain. Lights far less likely than 2^-24 share the
/// same values of u.
template <class L>
SHEAF_INLINE LightTreeSample<L> sample_light_tree(const LightTreeView& tree, Vec3<L> p, Vec3<L> n, Mask<L> has_normal,
                                                  typename L::Float u) {
  if (tree.node_count == 0) return {Uint<L>(0u), Float<L>(0.0f), u, Mask<L>(false)};
  LightTreeWalk<L> walk[1] = {begin_light_walk<L>(p, n, has_normal, u)};
  LightTreeSample<L> sample[1];
  end_light_walks<L>(tree, walk, sample);
  return sample[0];
}

/// The upper levels of the tree evaluated for one point, shared by all its candidates.
template <class L> struct LightTreeCut {
  /// Cumulative probabilities of each upper node's first one, two and three children. kAlwaysFirst if there is no node,
  /// because a leaf lies above it; kNoTurn if none of its lights can contribute.
  typename L::Float below[(kLightChildren - 1) * kLightTopTurns];

  static constexpr float kAlwaysFirst = 2, kNoTurn = -1;
  static constexpr auto fields(auto& s) { return std::tie(s.below); }
};

/// Evaluates the upper levels of the tree for a point; see sample_light_tree(). The tree must have lights.
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

/// As begin_light_walk() without `top`, up to rounding. `top` must have been computed for the same point.
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

/// The probability with which sample_light_tree() chooses `light` for the same point and normal. 0 in lanes that are
/// not `active`, where `light` may hold any value.
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
