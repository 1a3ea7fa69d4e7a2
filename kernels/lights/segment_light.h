// Choice of a light for a segment of a ray in a medium, and equiangular sampling of a point on the segment (Kulla and
// Fajardo, "Importance Sampling Techniques for Path Tracing in Participating Media", 2012, section 4).
//
// A light tree chooses the light in proportion to power times the integral of 1 / distance^2 along the segment, which
// is the angle that the segment subtends at the light, over the light's distance from the line. Conty Estevez and Kulla
// (2018), section 5.3, use the same measure. Lights have a size: distances from the line are at least the radius of a
// light's bounding sphere.
#pragma once

#include "core/sampling/warp.h"
#include "kernels/lights/light_tree.h"

namespace sheaf {

namespace light_tree_detail {

/// Points at distances from 0 to `length` (m) along a ray. `direction`: unit length.
template <class L> struct RaySegment {
  Vec3<L> p;  ///< the first point
  Vec3<L> direction;
  typename L::Float length;
};

}  // namespace light_tree_detail
using light_tree_detail::RaySegment;

/// Density of points on a segment that is uniform in the angle at which a light sees them.
template <class L> struct EquiangularDensity {
  typename L::Float middle;         ///< distance along the ray of the point closest to the light, m
  typename L::Float height;         ///< of the light above the line, m; positive
  typename L::Float first, extent;  ///< angle at the first point, and the angle that the segment subtends

  /// Distance along the ray for u in [0, 1).
  SHEAF_INLINE typename L::Float sample(typename L::Float u, typename L::Float length) const {
    using F = Float<L>;
    // The tangent has a period of half a turn.
    const SinCos<L> angle = sincos_2pi<L>(fma(fma(u, extent, first), F(0.5f * kInvPi), F(0.5f)));
    const F tangent = angle.sin / min(angle.cos, F(-1e-7f));
    return clamp(fma(height, tangent, middle), F(0.0f), length);
  }
  /// Pdf of the distance `t`, 1/m.
  SHEAF_INLINE typename L::Float pdf(typename L::Float t) const {
    const Float<L> along = t - middle;
    return height / max(extent * fma(height, height, along * along), Float<L>(1e-37f));
  }
};

namespace light_tree_detail {

/// A light's bounding sphere beside a segment.
template <class L> struct SegmentView {
  typename L::Float middle, height;  ///< see EquiangularDensity
};

/// `center`: relative to the first point of the segment.
template <class L>
SHEAF_INLINE SegmentView<L> view_segment(const RaySegment<L>& segment, Vec3<L> center, typename L::Float radius) {
  constexpr float kLeastHeight = 1e-9f;
  const Float<L> middle = dot(center, segment.direction);
  const Vec3<L> above = center - segment.direction * middle;
  return {middle, sqrt(fma(radius, radius, dot(above, above)) + Float<L>(kLeastHeight * kLeastHeight))};
}

/// Power times the integral of 1 / distance^2; see the top of this file. Ignores the directions of emission. The angle
/// a is approximated by 2 x / (1 + 2 x / pi) for x = tan(a / 2).
template <class L> SHEAF_INLINE Importance<L> importance(const LightChild<L>& child, const RaySegment<L>& segment) {
  using F = Float<L>;
  const SegmentView<L> view = view_segment<L>(segment, child.center, child.radius);
  const F left = segment.length - view.middle, squared = view.height * view.height;
  const F lengths = sqrt(fma(view.middle, view.middle, squared)) * sqrt(fma(left, left, squared));
  const F sine = view.height * segment.length, cosine = squared - view.middle * left;  // times both lengths
  const F weight =
      child.power_fraction * (F(2.0f) * segment.length) / fma(F(2.0f * kInvPi), sine, max(lengths + cosine, F(1e-37f)));
  const auto shines = child.spread >= F(0.0f);  // NaN: no power
  return {select(shines, weight, F(0.0f)), shines};
}

template <class L>
SHEAF_INLINE EquiangularDensity<L> equiangular_density(const RaySegment<L>& segment, const SegmentView<L>& view) {
  using F = Float<L>;
  const F left = segment.length - view.middle;
  const F extent = atan2(view.height * segment.length, view.height * view.height - view.middle * left);
  return {view.middle, view.height, atan2(-view.middle, view.height), extent};
}

/// The child in registers; `node` is relative to the segment.
template <class L>
SHEAF_INLINE EquiangularDensity<L> density_of_child(const NodeWords<L>& node, typename L::Uint child,
                                                    const RaySegment<L>& segment) {
  const LightChild<L> children[kLightChildren] = {
      unpack_light_child<L, 0>(node.words), unpack_light_child<L, 1>(node.words), unpack_light_child<L, 2>(node.words),
      unpack_light_child<L, 3>(node.words)};
  const auto picked = [&](auto&& member) SHEAF_LAMBDA_INLINE {
    const typename L::Float values[kLightChildren] = {member(children[0]), member(children[1]), member(children[2]),
                                                      member(children[3])};
    return pick<L>(values, child);
  };
  const Vec3<L> center{picked([](const LightChild<L>& c) { return c.center.x; }),
                       picked([](const LightChild<L>& c) { return c.center.y; }),
                       picked([](const LightChild<L>& c) { return c.center.z; })};
  const SegmentView<L> view = view_segment<L>(segment, center, picked([](const LightChild<L>& c) { return c.radius; }));
  return equiangular_density<L>(segment, view);
}

}  // namespace light_tree_detail

/// Segments that subtend a smaller angle at a light are not connected to it: the light is far away, and all points are
/// about as good.
inline constexpr float kLeastSegmentAngle = 0.3f;

/// A light for a segment, and the density of points for it.
template <class L> struct SegmentLight {
  typename L::Uint light;         ///< its index; 0 unless the probability is positive
  typename L::Float probability;  ///< of choosing it; 0: no light can reach the segment, or the angle is too small
  EquiangularDensity<L> density;
};

/// Chooses a light by u in [0, 1). The tree must have lights.
template <class L>
SHEAF_INLINE SegmentLight<L> choose_segment_light(const LightTreeView& tree, const RaySegment<L>& segment,
                                                  typename L::Float u) {
  using namespace light_tree_detail;
  using F = Float<L>;
  using U = Uint<L>;
  Traversal<L> state = Traversal<L>::at_root(u);
  U position(0u), branch(0u);
  NodeWords<L> leaf{};
  for (;;) {
    const auto active = ((position & U(kLightLeaf)) == U(0u)) & state.possible();
    if (!any(active)) break;
    const U index = select(active, position, U(0u));
    const NodeWords<L> node = load_node<L>(tree, index, segment);
    const U child = state.sample_child(child_weights<L>(node, segment), active);
    position = select(active, child_position<L>(node, index, child), position);
    branch = select(active, child, branch);
    for (int k = 0; k < LightNodeRow::kWordCount; ++k) leaf.words[k] = select(active, node.words[k], leaf.words[k]);
  }
  constexpr std::uint32_t kRowWords = sizeof(LightNodeRow) / sizeof(std::uint32_t);
  const auto valid = state.possible();
  const U row = select(valid, position & U(~kLightLeaf), U(0u));
  const U light = gather(tree.nodes->lights, (row >> 2) * U(kRowWords) + (row & U(3u)));
  const EquiangularDensity<L> density = density_of_child<L>(leaf, branch, segment);
  const auto connects = valid & (density.extent >= F(kLeastSegmentAngle));
  return {select(connects, light, U(0u)), select(connects, state.pmf_numerator / state.pmf_denominator, F(0.0f)),
          density};
}

/// The probability with which choose_segment_light() chooses `light`, and its density. The probability is 0 in lanes
/// that are not `active`, where `light` may hold any value.
template <class L>
SHEAF_INLINE SegmentLight<L> find_segment_light(const LightTreeView& tree, const RaySegment<L>& segment,
                                                typename L::Uint light, Mask<L> active) {
  using namespace light_tree_detail;
  using F = Float<L>;
  using U = Uint<L>;
  U trail = gather(tree.trails, select(active, light, U(0u)));
  U index(0u), branch(0u);
  NodeWords<L> leaf{};
  F pmf_numerator = select(active, F(1.0f), F(0.0f)), pmf_denominator(1.0f);
  while (any(active)) {
    const NodeWords<L> node = load_node<L>(tree, index, segment);
    const ChildWeights<L> children = child_weights<L>(node, segment);
    const U child = trail & U(3u);
    const F sum = children.sum(), scale = reciprocal_power_of_two<L>(sum);
    pmf_numerator = select(active, pmf_numerator * (pick<L>(children.weights, child) * scale), pmf_numerator);
    pmf_denominator = select(active, pmf_denominator * (sum * scale), pmf_denominator);
    branch = select(active, child, branch);
    for (int k = 0; k < LightNodeRow::kWordCount; ++k) leaf.words[k] = select(active, node.words[k], leaf.words[k]);
    const U position = child_position<L>(node, index, child);
    active = active & ((position & U(kLightLeaf)) == U(0u)) & (pmf_numerator > F(0.0f));
    trail = trail >> 2;
    index = select(active, position, U(0u));
  }
  const EquiangularDensity<L> density = density_of_child<L>(leaf, branch, segment);
  const auto connects = (pmf_numerator > F(0.0f)) & (density.extent >= F(kLeastSegmentAngle));
  return {light, select(connects, pmf_numerator / pmf_denominator, F(0.0f)), density};
}

}  // namespace sheaf
