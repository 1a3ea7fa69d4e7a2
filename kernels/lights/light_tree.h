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

/// What a node may contribute: `weight` / `distance_squared`, up to a factor that its sibling shares.
template <class L> struct Importance {
  typename L::Float weight, distance_squared;
};

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

template <class L> SHEAF_INLINE Importance<L> importance(const LightNode<L>& node, const Receiver<L>& at) {
  using F = Float<L>;
  using U = Uint<L>;
  const F zero(0.0f), one(1.0f), radius = node.radius;
  const Vec3<L> d = node.center - at.p;
  const F squared = clamp(dot(d, d), F(kNearSquared), F(kFarSquared));
  const F radius_squared = radius * radius, inverse = one / squared;
  const auto inside = squared <= max(radius_squared, F(kNearSquared));
  // The angle b under which the sphere around the lights is seen: cosine, sine x distance = to_edge, radius.
  const F to_edge = safe_sqrt(squared - radius_squared);

  // At the light: the angle w from the axis, less that of the cone, less b.
  const U keep_sign = U(0xffffffffu) ^ ((node.link & U(kLightTwoSided)) << 1);
  const F cos_w = bits_float(float_bits(-(node.axis.x * d.x + node.axis.y * d.y + node.axis.z * d.z)) & keep_sign);
  const F sin_w = safe_sqrt(squared - cos_w * cos_w);
  const F cos_x = cos_w * node.cos_theta_o + sin_w * node.sin_theta_o,
          sin_x = sin_w * node.cos_theta_o - cos_w * node.sin_theta_o;
  const auto in_cone = inside | (sin_x <= zero) | (sin_x * to_edge <= cos_x * radius);
  const F cos_light = select(in_cone, one, (cos_x * to_edge + sin_x * radius) * inverse);

  // At the receiver: the angle i from the normal, on the side where the light is, less b.
  const F cos_i = abs(dot(at.n, d)), sin_i = safe_sqrt(squared - cos_i * cos_i);
  const auto overhead = inside | (!at.facing) | (sin_i * to_edge <= cos_i * radius);
  const F cos_receiver = select(overhead, one, (cos_i * to_edge + sin_i * radius) * inverse);

  const F weight = node.share * max(cos_light, F(kLeastCosine)) * max(cos_receiver, F(kLeastCosine));
  return {select(cos_light > node.cos_theta_e, weight, zero), min(max(squared, radius_squared), F(kFarSquared))};
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
  const F to_first = a.weight * b.distance_squared, to_second = b.weight * a.distance_squared;
  const F sum = to_first + to_second;
  const auto possible = sum > zero;
  const F least = select(to_first > zero, F(kLeastTurn), zero);
  const F most = select(to_second > zero, F(1.0f - kLeastTurn), one);
  const F first = min(max(to_first / select(possible, sum, one), least), most);
  return {first, one - first, possible};
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
  using U = Uint<L>;
  const F one(1.0f);
  if (tree.node_count == 0) return {U(0u), F(0.0f), u, Mask<L>(false)};
  const Receiver<L> at = make_receiver<L>(p, n, has_normal);
  Mask<L> active(true);
  U node(0u), light(0u);
  F probability(1.0f), remapped = u;
  do {
    const NodePair<L> pair = load_pair<L>(tree, node);
    const Turn<L> way = turn<L>(pair, at);
    probability = select(active & !way.possible, F(0.0f), probability);
    active = active & way.possible;
    const auto goes_first = remapped < way.first;
    const F taken = select(goes_first, way.first, way.second);
    const F rest = (remapped - select(goes_first, F(0.0f), way.first)) / select(active, taken, one);
    remapped = select(active, min(rest, F(kOneMinusEpsilon)), remapped);
    probability = select(active, probability * taken, probability);
    const U link = select(goes_first, pair.first.link, pair.second.link);
    light = select(active, link & U(kLightIndex), light);
    active = active & ((link & U(kLightLeaf)) == U(0u));
    node = select(active, link & U(kLightIndex), U(0u));
  } while (any(active));
  const auto valid = probability > F(0.0f);
  return {select(valid, light, U(0u)), probability, remapped, valid};
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
