// MIS of three ways to find light that a homogeneous medium scatters once: (a) by sampling a distance and then a light
// from there, (b) by sampling a light for the segment of the ray and then a distance (kernels/stages/
// segment_lights.cpp), (c) by sampling a distance and then a direction. The point on the light has the same pdf in (a)
// and (b), so that the pdf of (b) is that of (a) times
//     rho = P_segment(light) p_equiangular(t) / (P_point(light) p(t)).
// With the power heuristic, (a) and (b) together are like light sampling whose pdf is larger by sqrt(1 + rho^2), of
// which (a) gets the fraction 1 / (1 + rho^2). Several candidates of (a) count as one: resampling does not place them
// where the segment does.
#pragma once

#include "kernels/lights/segment_light.h"
#include "kernels/wave/lane_mean.h"
#include "kernels/wave/wave.h"

namespace sheaf {

/// Segments end where the mean transmittance has fallen to exp(-kSegmentDepth): the rest contributes little.
inline constexpr float kSegmentDepth = 6;
/// Rays are connected, and directions sampled towards the glow of lights, until paths have scattered that often. In
/// dense media, later scatterings are many and gain nothing.
inline constexpr std::uint32_t kConnectedDepth = 4;

/// Length up to which segments are connected, m. `sigma_t`: extinction, 1/m.
template <class L> SHEAF_INLINE Float<L> segment_reach(ColorMode color, const Spectrum<L>& sigma_t) {
  return Float<L>(kSegmentDepth) / max(lane_mean<L>(color, sigma_t), Float<L>(1e-15f));
}

/// Pdfs of scattering at a distance in a homogeneous medium, by which lane of the path samples it.
template <class L> struct ScatteringPdf {
  Spectrum<L> sigma_t;    ///< 1/m
  typename L::Uint hero;  ///< the lane by which distances are sampled
  bool weighted;          ///< the other lanes have their own pdfs; see MediumRay

  /// Pdf per lane of a distance with transmittance `passed`, 1/m.
  SHEAF_INLINE Spectrum<L> at(const Spectrum<L>& passed) const {
    using U = Uint<L>;
    const Spectrum<L> pdf = sigma_t * passed;
    if (weighted) return pdf;
    return Spectrum<L>(
        select(hero < U(2u), select(hero == U(0u), pdf.c0, pdf.c1), select(hero == U(2u), pdf.c2, pdf.c3)));
  }
};

/// For rays with RayState::flags `flags` in a homogeneous medium.
template <class L>
SHEAF_INLINE ScatteringPdf<L> scattering_pdf(const StageContext& context, const Spectrum<L>& sigma_t,
                                             typename L::Uint flags) {
  using U = Uint<L>;
  const MediumEstimator estimator = context.integrator.medium_estimator;
  const bool by_largest = estimator == MediumEstimator::kDelta || estimator == MediumEstimator::kRatio;
  U hero = (flags & U(kRayHeroMask)) >> kRayHeroShift;
  if (by_largest) {
    const Float<L> largest = max_component(sigma_t);
    hero = select(sigma_t.c0 == largest, U(0u),
                  select(sigma_t.c1 == largest, U(1u), select(sigma_t.c2 == largest, U(2u), U(3u))));
  }
  return {sigma_t, hero, !by_largest};
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
