// Choice of a light for a segment of a ray in a medium, and equiangular sampling of a point on the segment (Kulla and
// Fajardo, "Importance Sampling Techniques for Path Tracing in Participating Media", 2012, section 4).
//
// A light tree chooses the light in proportion to power times the integral of 1 / distance^2 along the segment, which
// is the angle that the segment subtends at the light, over the light's distance from the line. Conty Estevez and Kulla
// (2018), section 5.3, use the same measure. Lights have a size: distances from the line are at least the radius of a
// light's bounding sphere. The beams of spot lights are cones: points are sampled on the part of the segment within.
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
  typename L::Float first, extent;  ///< angle at the first point, and the angle that the points subtend
  typename L::Float low, high;      ///< distances of the first and the last point, m

  /// Distance along the ray for u in [0, 1).
  SHEAF_INLINE typename L::Float sample(typename L::Float u) const {
    using F = Float<L>;
    // The tangent has a period of half a turn.
    const SinCos<L> angle = sincos_2pi<L>(fma(fma(u, extent, first), F(0.5f * kInvPi), F(0.5f)));
    const F tangent = angle.sin / min(angle.cos, F(-1e-7f));
    return clamp(fma(height, tangent, middle), low, high);
  }
  /// Pdf of the distance `t`, 1/m.
  SHEAF_INLINE typename L::Float pdf(typename L::Float t) const {
    using F = Float<L>;
    const F along = t - middle;
    const F inside = height / max(extent * fma(height, height, along * along), F(1e-37f));
    return select((t >= low) & (t <= high), inside, F(0.0f));
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

/// Distances along a ray.
template <class L> struct Interval {
  typename L::Float low, high;  ///< m; empty unless low < high
};

/// The part of a segment in the beam of a light: a cone around its directions of emission that contains its bounding
/// sphere. The whole segment if it emits to half a sphere or more. `child.center`: relative to the first point.
template <class L> SHEAF_INLINE Interval<L> clip_to_beam(const LightChild<L>& child, const RaySegment<L>& segment) {
  using F = Float<L>;
  const F zero(0.0f), one(1.0f), length = segment.length;
  const F cosine = min(one - child.reach - child.spread, F(0.99999f));  // cos(a + b) >= cos(a) - sin(b)
  const auto is_beam = (cosine > zero) & (child.keep_sign == Uint<L>(0xffffffffu));
  if (!any(is_beam)) return {zero, length};
  const F tilt = sqrt(max(dot(child.tilt, child.tilt), F(1e-30f)));
  const Vec3<L> axis = child.tilt * (F(-1.0f) / tilt);
  const F squared_cosine = cosine * cosine;
  const F behind = child.radius / sqrt(one - min(squared_cosine, F(0.99998f)));
  const Vec3<L> from = axis * behind - child.center;  // from the apex to the first point
  // Points inside: a t^2 + 2 b t + c >= 0
  const F along = dot(segment.direction, axis), start = dot(from, axis);
  const F a = fma(along, along, -squared_cosine), b = along * start - squared_cosine * dot(from, segment.direction),
          c = start * start - squared_cosine * dot(from, from);
  const F square = b * b - a * c, q = -(b + select(b < zero, -one, one) * sqrt(max(square, zero)));
  const F x = q / select(a == zero, F(1e-30f), a), y = c / select(q == zero, F(1e-30f), q);
  const F near = min(x, y), far = max(x, y);
  // A ray across the cone is inside between the roots, of which either cone has both; another one after or before both
  const auto crosses = a < zero;
  const F low = clamp(select(crosses | (along < zero), select(crosses, near, zero), far), zero, length);
  const F high = clamp(select(crosses | (along > zero), select(crosses, far, length), near), zero, length);
  const auto hits = (fma(F(0.5f) * (low + high), along, start) > zero) & ((square > zero) | !crosses);
  return {select(is_beam, low, zero), select(is_beam, select(hits, high, low), length)};
}

template <class L>
SHEAF_INLINE EquiangularDensity<L> equiangular_density(const SegmentView<L>& view, const Interval<L>& points) {
  using F = Float<L>;
  const F left = points.high - view.middle, first = points.low - view.middle;
  const F extent = atan2(view.height * (points.high - points.low), fma(view.height, view.height, left * first));
  return {view.middle, view.height, atan2(first, view.height), extent, points.low, points.high};
}

/// The child in registers; `node` is relative to the segment.
template <class L> SHEAF_INLINE LightChild<L> child_of(const NodeWords<L>& node, typename L::Uint child) {
  const LightChild<L> children[kLightChildren] = {
      unpack_light_child<L, 0>(node.words), unpack_light_child<L, 1>(node.words), unpack_light_child<L, 2>(node.words),
      unpack_light_child<L, 3>(node.words)};
  const auto picked = [&](auto&& member) SHEAF_LAMBDA_INLINE {
    const typename L::Float values[kLightChildren] = {member(children[0]), member(children[1]), member(children[2]),
                                                      member(children[3])};
    return pick<L>(values, child);
  };
  const auto vector = [&](Vec3<L> LightChild<L>::*v) SHEAF_LAMBDA_INLINE {
    return Vec3<L>{picked([v](const LightChild<L>& c) { return (c.*v).x; }),
                   picked([v](const LightChild<L>& c) { return (c.*v).y; }),
                   picked([v](const LightChild<L>& c) { return (c.*v).z; })};
  };
  const auto number = [&](typename L::Float LightChild<L>::*x)
                          SHEAF_LAMBDA_INLINE { return picked([x](const LightChild<L>& c) { return c.*x; }); };
  const auto keep_sign = picked([](const LightChild<L>& c) { return bits_float(c.keep_sign); });
  return {vector(&LightChild<L>::center), number(&LightChild<L>::radius), vector(&LightChild<L>::tilt),
          number(&LightChild<L>::spread), number(&LightChild<L>::reach),  number(&LightChild<L>::power_fraction),
          float_bits(keep_sign)};
}

}  // namespace light_tree_detail

/// Tangent of the angle that segments must subtend at a light to be connected to it, 0.3 radians. From farther away,
/// all points are about as good.
inline constexpr float kLeastSegmentTangent = 0.30934f;

/// A light for a segment, and the density of points for it.
template <class L> struct SegmentLight {
  typename L::Uint light;         ///< its index; 0 unless the probability is positive
  typename L::Float probability;  ///< of choosing it; 0: no light can reach the segment, or it is not connected
  EquiangularDensity<L> density;
};

namespace light_tree_detail {

/// The light of child `child` of `node`, chosen with probability `probability`.
template <class L>
SHEAF_INLINE SegmentLight<L> connect_segment(const NodeWords<L>& node, typename L::Uint child,
                                             const RaySegment<L>& segment, typename L::Uint light,
                                             typename L::Float probability) {
  using F = Float<L>;
  const LightChild<L> of = child_of<L>(node, child);
  const SegmentView<L> view = view_segment<L>(segment, of.center, of.radius);
  // Sine and cosine of the angle that the whole segment subtends, up to a factor
  const F sine = view.height * segment.length,
          cosine = fma(view.height, view.height, view.middle * (view.middle - segment.length));
  const EquiangularDensity<L> density = equiangular_density<L>(view, clip_to_beam<L>(of, segment));
  const auto connects =
      (probability > F(0.0f)) & (sine >= F(kLeastSegmentTangent) * cosine) & (density.high > density.low);
  return {select(connects, light, Uint<L>(0u)), select(connects, probability, F(0.0f)), density};
}

}  // namespace light_tree_detail

/// Chooses a light by u in [0, 1). The tree must have lights.
template <class L>
SHEAF_INLINE SegmentLight<L> choose_segment_light(const LightTreeView& tree, const RaySegment<L>& segment,
                                                  typename L::Float u) {
  using namespace light_tree_detail;
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
    leaf.set(active, node);
  }
  constexpr std::uint32_t kRowWords = sizeof(LightNodeRow) / sizeof(std::uint32_t);
  const auto valid = state.possible();
  const U row = select(valid, position & U(~kLightLeaf), U(0u));
  const U light = gather(tree.nodes->lights, (row >> 2) * U(kRowWords) + (row & U(3u)));
  return connect_segment<L>(leaf, branch, segment, light, state.probability());
}

/// The probability with which choose_segment_light() chooses `light`, and its density. The probability is 0 in lanes
/// that are not `active`, where `light` may hold any value.
template <class L>
SHEAF_INLINE SegmentLight<L> find_segment_light(const LightTreeView& tree, const RaySegment<L>& segment,
                                                typename L::Uint light, Mask<L> active) {
  using namespace light_tree_detail;
  const FoundLeaf<L> found = descend_to_light<L>(tree, segment, light, active);
  return connect_segment<L>(found.node, found.child, segment, light, found.probability);
}

}  // namespace sheaf
