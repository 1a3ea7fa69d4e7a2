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
inline constexpr float kMinProbability = 0x1p-20f;
/// Largest random number used for the selection.
inline constexpr float kMaxRandom = 1.0f - 0x1p-22f;
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

/// 1 / x for 0 <= x <= 1e10, within 1/20: the bits of a float approximate the logarithm of its value, so subtracting
/// them from a constant negates the logarithm. Larger x count as 1e10.
template <class L> SHEAF_INLINE Float<L> rough_reciprocal(typename L::Float x) {
  using U = Uint<L>;
  constexpr std::uint32_t kReciprocalBits = 0x7ef311c7u, kMaxBits = 0x501502f9u;
  return bits_float(U(kReciprocalBits) - min(float_bits(x), U(kMaxBits)));
}

/// A node in registers, as its words. The center of its bounds is relative to the receiver.
template <class L> struct NodeWords {
  typename L::Float words[LightNodeRow::kWordCount];

  template <class At> SHEAF_INLINE void move_to(const At& at) {
    words[LightNodeRow::kMiddle] = words[LightNodeRow::kMiddle] - at.p.x;
    words[LightNodeRow::kMiddle + 1] = words[LightNodeRow::kMiddle + 1] - at.p.y;
    words[LightNodeRow::kMiddle + 2] = words[LightNodeRow::kMiddle + 2] - at.p.z;
  }
  /// Sets the lanes `m`.
  SHEAF_INLINE void set(Mask<L> m, const NodeWords& other) {
    for (int k = 0; k < LightNodeRow::kWordCount; ++k) words[k] = select(m, other.words[k], words[k]);
  }
  SHEAF_INLINE Uint<L> link() const { return float_bits(words[LightNodeRow::kLink]); }
};

template <class L, class At>
SHEAF_INLINE NodeWords<L> load_node(const LightTreeView& tree, typename L::Uint index, const At& at) {
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

/// Importance of Conty Estevez and Kulla (2018), equation 3: power / distance^2 times the cosines at both ends, with
/// bounds on the cosines instead of their maxima. For a sphere of radius r whose center is at distance D and at
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
  // The distance counts as at least the radius.
  const F inverse_distance = min(inverse, rough_reciprocal<L>(child.radius));
  const F weight = child.power_fraction * (inverse_distance * inverse_distance) *
                   (clamp(cos_light, min_cosine, one) * min(cos_receiver, one));
  const auto shines = cos_light + child.reach > one;
  return {select(shines, weight, F(0.0f)), shines};
}

/// Selection weights of the children of a node, in proportion to their probabilities.
template <class L> struct ChildWeights {
  typename L::Float weights[kLightChildren];

  SHEAF_INLINE Float<L> sum() const { return (weights[0] + weights[1]) + (weights[2] + weights[3]); }
};

/// `at`: a Receiver, or a segment (kernels/lights/segment_light.h).
template <class L, class At> SHEAF_INLINE ChildWeights<L> child_weights(const NodeWords<L>& node, const At& at) {
  using F = Float<L>;
  const Importance<L> children[kLightChildren] = {
      importance<L>(unpack_light_child<L, 0>(node.words), at), importance<L>(unpack_light_child<L, 1>(node.words), at),
      importance<L>(unpack_light_child<L, 2>(node.words), at), importance<L>(unpack_light_child<L, 3>(node.words), at)};
  const F min_weight =
      ((children[0].weight + children[1].weight) + (children[2].weight + children[3].weight)) * F(kMinProbability);
  ChildWeights<L> out;
  for (int k = 0; k < kLightChildren; ++k)
    out.weights[k] = select(children[k].shines, max(children[k].weight, min_weight), F(0.0f));
  return out;
}

/// values[child] for child < 4.
template <class L> SHEAF_INLINE Float<L> pick(const typename L::Float* values, typename L::Uint child) {
  using U = Uint<L>;
  const auto is_odd = (child & U(1u)) != U(0u), is_upper = (child & U(2u)) != U(0u);
  return select(is_upper, select(is_odd, values[3], values[2]), select(is_odd, values[1], values[0]));
}

/// Position of a child of node `index`: see light_tree_child().
template <class L>
SHEAF_INLINE Uint<L> child_position(const NodeWords<L>& node, typename L::Uint index, typename L::Uint child) {
  using U = Uint<L>;
  const U link = node.link();
  return select(child < (link >> kLightNodeBits), (link & U(kLightNodeIndex)) + child,
                U(kLightLeaf) | (index << 2) | child);
}

/// State of the traversal of a tree from its root to a leaf. The remaining random number in [0, 1) and the probability
/// of reaching the current node are kept as fractions until the end, because a division would add latency to each
/// level.
template <class L> struct Traversal {
  typename L::Float u_numerator, u_denominator;
  typename L::Float pmf_numerator, pmf_denominator;

  static SHEAF_INLINE Traversal at_root(typename L::Float u) {
    return {u, Float<L>(1.0f), Float<L>(1.0f), Float<L>(1.0f)};
  }
  /// False: no light below the current node can contribute.
  SHEAF_INLINE Mask<L> possible() const { return pmf_numerator > Float<L>(0.0f); }
  /// The probability of reaching the current node.
  SHEAF_INLINE Float<L> probability() const {
    return select(possible(), pmf_numerator / pmf_denominator, Float<L>(0.0f));
  }

  /// Samples a child and returns its index; updates the `active` lanes.
  SHEAF_INLINE Uint<L> sample_child(const ChildWeights<L>& children, Mask<L> active) {
    using F = Float<L>;
    using U = Uint<L>;
    const auto& w = children.weights;
    const F sum = children.sum(), first = w[0], two = first + w[1], three = two + w[2];
    const F cdf[3] = {u_denominator * first, u_denominator * two, u_denominator * three};
    // Keep the number below the upper end despite rounding, so that children of weight 0 are never selected.
    const F u = min(u_numerator, u_denominator * F(kMaxRandom)) * sum;
    F cdf_below(0.0f), weight = first;
    U child(0u);
    for (std::uint32_t k = 1; k < kLightChildren; ++k) {
      const auto beyond = u >= cdf[k - 1];
      cdf_below = select(beyond, cdf[k - 1], cdf_below);
      weight = select(beyond, w[k], weight);
      child = select(beyond, U(k), child);
    }
    // Remap the random number and multiply the probabilities, both scaled by powers of two to stay near 1
    const F interval = u_denominator * weight;
    const F scale = reciprocal_power_of_two<L>(interval), scale_sum = reciprocal_power_of_two<L>(sum);
    u_numerator = select(active, (u - cdf_below) * scale, u_numerator);
    u_denominator = select(active, interval * scale, u_denominator);
    pmf_numerator = select(active, pmf_numerator * (weight * scale_sum), pmf_numerator);
    pmf_denominator = select(active, pmf_denominator * (sum * scale_sum), pmf_denominator);
    return child;
  }
};

}  // namespace light_tree_detail

/// A traversal of a light tree in progress; see finish_light_traversals().
template <class L> struct LightTreeTraversal {
  light_tree_detail::Receiver<L> at;
  light_tree_detail::Traversal<L> state;
  typename L::Uint position;  ///< current position in the tree
};

/// Completes all traversals, interleaved to hide their latency: each level depends on the one above. The tree must have
/// lights.
template <class L, int N>
SHEAF_INLINE void finish_light_traversals(const LightTreeView& tree, LightTreeTraversal<L> (&traversals)[N],
                                          LightTreeSample<L> (&samples)[N]) {
  using namespace light_tree_detail;
  using F = Float<L>;
  using U = Uint<L>;
  const auto is_active = [](const LightTreeTraversal<L>& traversal) SHEAF_LAMBDA_INLINE {
    return ((traversal.position & U(kLightLeaf)) == U(0u)) & traversal.state.possible();
  };
  Mask<L> active[N];
  const auto any_active = [&]() SHEAF_LAMBDA_INLINE {
    for (int i = 0; i < N; ++i) active[i] = is_active(traversals[i]);
    Mask<L> all = active[0];
    for (int i = 1; i < N; ++i) all = all | active[i];
    return any(all);
  };
  // Descend by one level at a time
  while (any_active()) {
    for (int i = 0; i < N; ++i) {
      LightTreeTraversal<L>& traversal = traversals[i];
      const U index = select(active[i], traversal.position, U(0u));
      const NodeWords<L> node = load_node<L>(tree, index, traversal.at);
      const U child = traversal.state.sample_child(child_weights<L>(node, traversal.at), active[i]);
      traversal.position = select(active[i], child_position<L>(node, index, child), traversal.position);
    }
  }
  // Read the lights at the leaves
  constexpr std::uint32_t kRowWords = sizeof(LightNodeRow) / sizeof(std::uint32_t);
  for (int i = 0; i < N; ++i) {
    const Traversal<L>& end = traversals[i].state;
    const auto valid = end.possible();
    const F remapped = clamp(end.u_numerator / select(valid, end.u_denominator, F(1.0f)), F(0.0f), F(kOneMinusEpsilon));
    const U leaf = select(valid, traversals[i].position & U(~kLightLeaf), U(0u));
    const U light = gather(tree.nodes->lights, (leaf >> 2) * U(kRowWords) + (leaf & U(3u)));
    samples[i] = {select(valid, light, U(0u)), select(valid, end.pmf_numerator / end.pmf_denominator, F(0.0f)),
                  remapped, valid};
  }
}

/// Begins the traversal of sample_light_tree().
template <class L>
SHEAF_INLINE LightTreeTraversal<L> begin_light_traversal(Vec3<L> p, Vec3<L> n, Mask<L> has_normal,
                                                         typename L::Float u) {
  using namespace light_tree_detail;
  return {make_receiver<L>(p, n, has_normal), Traversal<L>::at_root(u), Uint<L>(0u)};
}

/// Samples a light for the point `p` by `u` in [0, 1). `n`: unit shading normal; light on either side of it counts. A
/// zero `n`, or `has_normal` false, means a point in a medium. Every light that can reach `p` has a positive
/// probability. About 24 - log2(1 / probability) random bits of u remain. Lights far less likely than 2^-24 use the
/// same values of u.
template <class L>
SHEAF_INLINE LightTreeSample<L> sample_light_tree(const LightTreeView& tree, Vec3<L> p, Vec3<L> n, Mask<L> has_normal,
                                                  typename L::Float u) {
  if (tree.node_count == 0) return {Uint<L>(0u), Float<L>(0.0f), u, Mask<L>(false)};
  LightTreeTraversal<L> traversal[1] = {begin_light_traversal<L>(p, n, has_normal, u)};
  LightTreeSample<L> sample[1];
  finish_light_traversals<L>(tree, traversal, sample);
  return sample[0];
}

/// The upper levels of the tree evaluated for one point, shared by all its candidates.
template <class L> struct LightTreeCut {
  /// Cumulative probabilities of each upper node's first one, two and three children. kSkipNode if there is no node,
  /// because a leaf lies above it; kUnreachable if none of its lights can contribute.
  typename L::Float cdf[(kLightChildren - 1) * kLightCutNodes];

  static constexpr float kSkipNode = 2, kUnreachable = -1;
  static constexpr auto fields(auto& s) { return std::tie(s.cdf); }
};

/// Evaluates the upper levels of the tree for a point; see sample_light_tree(). The tree must have lights.
template <class L>
SHEAF_INLINE LightTreeCut<L> light_tree_cut(const LightTreeView& tree, Vec3<L> p, Vec3<L> n, Mask<L> has_normal) {
  using namespace light_tree_detail;
  using F = Float<L>;
  const Receiver<L> at = make_receiver<L>(p, n, has_normal);
  LightTreeCut<L> out;
  for (int node = 0; node < kLightCutNodes; ++node) {
    F* const cdf = out.cdf + (kLightChildren - 1) * node;
    for (int k = 0; k + 1 < kLightChildren; ++k) cdf[k] = F(LightTreeCut<L>::kSkipNode);
    const std::uint32_t position = tree.cut_nodes[node];
    if ((position & kLightLeaf) != 0) continue;
    const ChildWeights<L> children = child_weights<L>(broadcast<L>(tree.nodes[position], at), at);
    const F sum = children.sum();
    const auto possible = sum > F(0.0f);
    const F inverse = F(1.0f) / select(possible, sum, F(1.0f));
    F partial_sum(0.0f);
    for (int k = 0; k + 1 < kLightChildren; ++k) {
      partial_sum = partial_sum + children.weights[k];
      cdf[k] = select(possible, min(partial_sum * inverse, F(1.0f)), F(LightTreeCut<L>::kUnreachable));
    }
  }
  return out;
}

/// As begin_light_traversal() without a cut, up to rounding. `cut` must have been computed for the same point.
template <class L>
SHEAF_INLINE LightTreeTraversal<L> begin_light_traversal(const LightTreeView& tree, const LightTreeCut<L>& cut,
                                                         Vec3<L> p, Vec3<L> n, Mask<L> has_normal,
                                                         typename L::Float u) {
  using namespace light_tree_detail;
  using F = Float<L>;
  using U = Uint<L>;
  static_assert(kLightCutLevels == 2);
  constexpr int kCdfSize = kLightChildren - 1;
  const F zero(0.0f), one(1.0f);
  Traversal<L> state = Traversal<L>::at_root(u);
  const auto sample_child = [&](const F* cdf) SHEAF_LAMBDA_INLINE {
    const auto known = (cdf[0] >= zero) & (cdf[0] <= one);
    const ChildWeights<L> children{{select(known, cdf[0], zero), select(known, cdf[1] - cdf[0], zero),
                                    select(known, cdf[2] - cdf[1], zero), select(known, one - cdf[2], zero)}};
    return select(cdf[0] > one, U(0u), state.sample_child(children, cdf[0] <= one));
  };
  // Sample a child of the root
  const U first = sample_child(cut.cdf);
  // Sample a child of that node
  F cdf[kCdfSize];
  for (int k = 0; k < kCdfSize; ++k) {
    const F of_children[kLightChildren] = {cut.cdf[kCdfSize + k], cut.cdf[2 * kCdfSize + k], cut.cdf[3 * kCdfSize + k],
                                           cut.cdf[4 * kCdfSize + k]};
    cdf[k] = pick<L>(of_children, first);
  }
  const U second = sample_child(cdf);
  const U position = gather(tree.cut_nodes, (first << 2) + second + U(kLightCutNodes));
  return {make_receiver<L>(p, n, has_normal), state, position};
}

namespace light_tree_detail {

/// The leaf of a light.
template <class L> struct FoundLeaf {
  typename L::Float probability;  ///< of choosing it; 0 in lanes that are not active
  NodeWords<L> node;              ///< its node, relative to the receiver or segment
  typename L::Uint child;         ///< the child of that node
};

/// Descends to a light. `at`: see child_weights().
template <class L, class At>
SHEAF_INLINE FoundLeaf<L> descend_to_light(const LightTreeView& tree, const At& at, typename L::Uint light,
                                           Mask<L> active) {
  using F = Float<L>;
  using U = Uint<L>;
  FoundLeaf<L> out{};
  U trail = gather(tree.trails, select(active, light, U(0u)));
  U index(0u);
  F pmf_numerator = select(active, F(1.0f), F(0.0f)), pmf_denominator(1.0f);
  while (any(active)) {
    const NodeWords<L> node = load_node<L>(tree, index, at);
    const ChildWeights<L> children = child_weights<L>(node, at);
    const U child = trail & U(3u);
    const F sum = children.sum(), scale = reciprocal_power_of_two<L>(sum);
    pmf_numerator = select(active, pmf_numerator * (pick<L>(children.weights, child) * scale), pmf_numerator);
    pmf_denominator = select(active, pmf_denominator * (sum * scale), pmf_denominator);
    out.child = select(active, child, out.child);
    out.node.set(active, node);
    const U position = child_position<L>(node, index, child);
    active = active & ((position & U(kLightLeaf)) == U(0u)) & (pmf_numerator > F(0.0f));
    trail = trail >> 2;
    index = select(active, position, U(0u));
  }
  out.probability = select(pmf_numerator > F(0.0f), pmf_numerator / pmf_denominator, F(0.0f));
  return out;
}

}  // namespace light_tree_detail

/// The probability with which sample_light_tree() chooses `light` for the same point and normal. 0 in lanes that are
/// not `active`, where `light` may hold any value.
template <class L>
SHEAF_INLINE Float<L> light_tree_probability(const LightTreeView& tree, Vec3<L> p, Vec3<L> n, Mask<L> has_normal,
                                             typename L::Uint light, Mask<L> active) {
  using namespace light_tree_detail;
  if (tree.node_count == 0) return Float<L>(0.0f);
  return descend_to_light<L>(tree, make_receiver<L>(p, n, has_normal), light, active).probability;
}

}  // namespace sheaf
