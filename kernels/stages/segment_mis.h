// MIS of three ways to find light that a medium scatters once: (a) by sampling a distance and then a light
// from there, (b) by sampling a light for the segment of the ray and then a distance (kernels/stages/
// segment_lights.cpp), (c) by sampling a distance and then a direction. The point on the light has the same pdf in (a)
// and (b), so that the pdf of (b) is that of (a) times
//     rho = P_segment(light) p_equiangular(t) / (P_point(light) p(t)).
// With the power heuristic, (a) and (b) together are like light sampling whose pdf is larger by sqrt(1 + rho^2), of
// which (a) gets the fraction 1 / (1 + rho^2). Several candidates of (a) count as one: resampling does not place them
// where the segment does.
//
// In media with a grid, p(t) is unknown. The weights use the pdf at the mean extinction instead, times the density at t
// over its mean: any function of t keeps their sum at one.
#pragma once

#include "kernels/lights/segment_light.h"
#include "kernels/media/majorant_walk.h"
#include "kernels/wave/lane_mean.h"
#include "kernels/wave/wave.h"

namespace sheaf {

/// Rays are connected, and directions sampled towards the glow of lights, until paths have scattered that often. In
/// dense media, later scatterings are many and gain nothing.
inline constexpr std::uint32_t kConnectedDepth = 4;

/// The part of a ray in a medium that is connected to lights.
template <class L> struct ConnectedPart {
  typename L::Float start, length;  ///< m; length 0: none
};

/// For a ray that leaves the medium, or ends, after `length` meters. `sigma_t`: extinction of a homogeneous medium,
/// 1/m.
template <class L>
SHEAF_INLINE ConnectedPart<L> connected_part(const SceneView& scene, const MediumRow& medium, const Vec3<L>& origin,
                                             const Vec3<L>& direction, typename L::Float length,
                                             const Spectrum<L>& sigma_t) {
  using F = Float<L>;
  const F depth(kSegmentDepth);
  if ((medium.flags & kMediumHomogeneous) != 0)
    return {F(0.0f), min(length, depth / max(lane_mean<L>(scene.color, sigma_t), F(1e-15f)))};
  Mask<L> hits;
  const LeafWalk<L> box =
      start_leaf_walk<L>(scene.media.majorants[medium.majorants], origin, direction, F(0.0f), length, hits);
  const F within = min(box.leave - box.t, depth / max(F(medium.mean_extinction), F(1e-15f)));
  return {select(hits, box.t, F(0.0f)), select(hits, within, F(0.0f))};
}

/// The segment on which paths scatter `t` meters along their rays. `sigma`: extinction of the hero lane there, 1/m.
/// `extinction`: the extinction up to there, 1/m, of a grid its mean. `before` and `after`: means of r_u before and
/// after the distance was sampled.
template <class L>
SHEAF_INLINE SegmentState<L> scattered_segment(const ConnectedPart<L>& part, const Vec3<L>& origin,
                                               const Vec3<L>& direction, Float<L> t, Float<L> sigma,
                                               Float<L> extinction, Float<L> before, Float<L> after) {
  using F = Float<L>;
  const F along = t - part.start, pdf = sigma * exp(extinction * -along) * after;
  const auto connected = (along < part.length) & (pdf > F(0.0f));
  return {origin + direction * part.start, part.length, direction, select(connected, before / pdf, F(0.0f))};
}

/// sqrt(1 + rho^2) for light sampling from `p`, the last vertices of paths, in lanes whose vertices lie on connected
/// segments; elsewhere 1. `point_pdf`: P_point(light).
template <class L>
SHEAF_INLINE Float<L> segment_pdf_scale(const SceneView& scene, const Wave& wave, const Slot* slots, Vec3<L> p,
                                        typename L::Uint light, typename L::Float point_pdf, Mask<L> lanes) {
  using F = Float<L>;
  const SegmentState<L> segment = wave.segments.gather<L>(slots);
  const auto active =
      lanes & (segment.pdf_ratio > F(0.0f)) & (point_pdf > F(0.0f)) & (light < Uint<L>(scene.lights.bounded_count));
  if (!any(active)) return F(1.0f);
  const RaySegment<L> ray{segment.origin, segment.direction, segment.length};
  const SegmentLight<L> chosen = find_segment_light<L>(scene.lights.tree, ray, light, active);
  const F density = chosen.density.pdf(dot(p - segment.origin, segment.direction));
  const F rho = min(chosen.probability * density * segment.pdf_ratio / select(active, point_pdf, F(1.0f)), F(1e15f));
  return select(active, sqrt(fma(rho, rho, F(1.0f))), F(1.0f));
}

}  // namespace sheaf
