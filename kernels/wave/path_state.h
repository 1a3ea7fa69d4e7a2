// What a path carries from stage to stage: four records of 32 bytes, reached by slot.
#pragma once

#include "core/slot_table.h"
#include "core/spectrum.h"
#include "scene/tables/material.h"

namespace sheaf {

/// The ray to be traced next.
template <class L> struct RayState {
  Vec3<L> origin;
  typename L::Float t_max;  ///< farthest distance
  Vec3<L> direction;        ///< normalised
  typename L::Uint flags;   ///< RayFlags
  static constexpr auto fields(auto& s) { return std::tie(s.origin, s.t_max, s.direction, s.flags); }
};

/// Bits of RayState::flags. The lane by whose extinction distances in media are sampled stands above them, the medium
/// that the ray is in above that: 0 for vacuum, else 1 + its row.
enum RayFlags : std::uint32_t {
  kRayFromCamera = 1,  ///< nothing but null interfaces lies between the camera and the origin
  kRayLast = 2,        ///< what the ray hits may emit but will not scatter: max_depth is reached
  kRayFromMedium = 4,  ///< was scattered in a medium
  // History, for photon maps.
  kRayDiffuse = 8,    ///< the path was scattered by a surface, and not as by a mirror; photons: or in a medium
  kRaySpecular = 64,  ///< photons: was scattered as by a mirror
  kRayScatteredInMedium = 128,  ///< camera: was scattered in a medium since kRayDiffuse
};
inline constexpr std::uint32_t kRayHistory = kRayDiffuse | kRaySpecular | kRayScatteredInMedium;
inline constexpr int kRayHeroShift = 4, kRayMediumShift = 8;
inline constexpr std::uint32_t kRayHeroMask = 3u << kRayHeroShift;

/// What the ray hit.
template <class L> struct HitState {
  typename L::Float t;         ///< distance
  typename L::Float u, v;      ///< barycentric coordinates
  typename L::Uint primitive;  ///< triangle of the shape
  typename L::Uint shape;
  typename L::Uint instance;
  typename L::Uint material;  ///< row, the one for this side of the surface
  typename L::Uint light;     ///< row; kNone: does not emit
  static constexpr auto fields(auto& s) {
    return std::tie(s.t, s.u, s.v, s.primitive, s.shape, s.instance, s.material, s.light);
  }
};

/// How much the path's next radiance counts, and which sample it belongs to.
template <class L> struct PathState {
  Spectrum<L> beta;                      ///< throughput over probability
  typename L::Float eta_scale;           ///< squared relative index of refraction along the path; roulette takes it out
  typename L::Uint depth_and_dimension;  ///< depth in the lower, dimension() in the upper 16 bits
  typename L::Uint pixel;                ///< y * frame width + x
  typename L::Uint sample;               ///< absolute sample index of the pixel
  static constexpr auto fields(auto& s) {
    return std::tie(s.beta, s.eta_scale, s.depth_and_dimension, s.pixel, s.sample);
  }

  /// Vertices that cost depth.
  SHEAF_INLINE typename L::Uint depth() const { return depth_and_dimension & typename L::Uint(0xffffu); }
  /// Which random numbers come next: one more for each interaction.
  SHEAF_INLINE typename L::Uint dimension() const { return depth_and_dimension >> 16; }
};
inline constexpr std::uint32_t kOneDepth = 1u, kOneDimension = 1u << 16;
/// Depths and dimensions stop counting here, so that neither runs into the other's bits; paths this long end.
inline constexpr std::uint32_t kLongestPath = 0x7fffu;

/// What the path has gathered.
template <class L> struct RadianceState {
  Spectrum<L> radiance;           ///< so far
  typename L::Float scatter_pdf;  ///< solid-angle density of the current direction; 0: camera ray or specular
  typename L::Uint normal;        ///< octahedral; shading normal where the ray was scattered, for the choice of lights
  typename L::Float weight;       ///< reconstruction filter weight of the sample
  typename L::Uint task_sample;   ///< index into the task's sample buffer, and kTransparent
  static constexpr auto fields(auto& s) {
    return std::tie(s.radiance, s.scatter_pdf, s.normal, s.weight, s.task_sample);
  }
};
/// Bit of RadianceState::task_sample: the camera ray has met nothing that counts as covered.
inline constexpr std::uint32_t kTransparent = 0x80000000u;

/// Probabilities of the path so far, had each lane in turn been the one by which distances in media are sampled, over
/// the probability by which the throughput was divided (Miller, Georgiev and Jarosz, "A Null-Scattering Path Integral
/// Formulation of Light Transport", 2019; rescaled as in Pharr et al. 2023, section 14.2.1). Only where
/// SceneView::needs_transmittance.
template <class L> struct RescaledPdfs {
  Spectrum<L> r_u;  ///< sampled direction by direction
  Spectrum<L> r_l;  ///< the last vertex as r_u, what follows as light sampling goes about it
  static constexpr auto fields(auto& s) { return std::tie(s.r_u, s.r_l); }
};

/// A surface vertex ready for shading, in order of closure kind; consumed in order.
template <class L> struct VertexItem {
  Vec3<L> p;                 ///< world space
  Vec3<L> ng;                ///< geometric normal, unit length
  Vec3<L> ns;                ///< shading normal, unit length; turned towards the viewer for two-sided materials
  Vec3<L> wo;                ///< towards where the path came from, in the shading frame
  typename L::Float offset;  ///< see SurfacePoint::offset
  Vec2<L> tangent;           ///< the shading frame's x axis, see ShadingFrame; only for anisotropic closures
  static constexpr auto fields(auto& s) { return std::tie(s.p, s.ng, s.ns, s.wo, s.offset, s.tangent); }
};

/// What textures need to know of a surface vertex. Only for materials with kNeedsUv.
template <class L> struct TexturedItem {
  Vec2<L> uv;
  Vec3<L> dp_du, dp_dv;             ///< derivatives of the position
  Vec3<L> ns_unmapped;              ///< VertexItem::ns before a map turned it
  typename L::Float handedness;     ///< -1 where ns was turned towards the viewer, else 1
  typename L::Float terminator;     ///< how much a map softens the edge of shadows; see shadow_terminator()
  typename L::Float normal_choice;  ///< of photons; see matches_normal_choice()
  static constexpr auto fields(auto& s) {
    return std::tie(s.uv, s.dp_du, s.dp_dv, s.ns_unmapped, s.handedness, s.terminator, s.normal_choice);
  }
};

/// Parameters of a closure, as many words as the kind needs.
template <class L> struct ClosureItem {
  typename L::Float words[kMaxClosureWords];
  static constexpr auto fields(auto& s) { return std::tie(s.words); }
};

/// A light that may be worth a shadow ray; stands where its VertexItem stands.
template <class L> struct LightCandidate {
  Vec3<L> direction;                  ///< towards the light, unit length
  Vec3<L> target;                     ///< where the shadow ray ends
  Spectrum<L> radiance;               ///< see LightSample::radiance
  typename L::Float pdf_solid_angle;  ///< see LightSample::pdf_solid_angle; 0: nothing arrives
  typename L::Float delta;            ///< 1: BSDF sampling cannot find this light; else 0
  typename L::Uint light;             ///< row
  typename L::Uint target_medium;     ///< see TransmittanceItem::target_medium
  static constexpr auto fields(auto& s) {
    return std::tie(s.direction, s.target, s.radiance, s.pdf_solid_angle, s.delta, s.light, s.target_medium);
  }
};

/// What resampling has kept of the candidates so far; stands where its VertexItem stands.
template <class L> struct ReservoirItem {
  Vec3<L> target;                  ///< of the candidate that was kept
  Spectrum<L> contribution;        ///< what it brings if unoccluded, over its density
  typename L::Float weight;        ///< that contribution's luminance: its resampling weight
  typename L::Float sum;           ///< of the weights of all candidates
  typename L::Float u;             ///< uniform in [0, 1), for the next choice
  typename L::Float pdf_ratio;     ///< see TransmittanceItem::pdf_ratio
  typename L::Uint light;          ///< row
  typename L::Uint target_medium;  ///< see TransmittanceItem::target_medium
  typename L::Uint single;         ///< 1: of four wavelengths, the first alone goes to the target; else 0
  static constexpr auto fields(auto& s) {
    return std::tie(s.target, s.contribution, s.weight, s.sum, s.u, s.pdf_ratio, s.light, s.target_medium, s.single);
  }
};

/// Where the camera sees a vertex of a photon; stands where its VertexItem stands.
template <class L> struct RasterPosition {
  typename L::Float x, y;  ///< film position, pixels
  static constexpr auto fields(auto& s) { return std::tie(s.x, s.y); }
};

/// Where the guide knows of a vertex; stands where its VertexItem stands.
template <class L> struct GuideCell {
  typename L::Uint row;   ///< of GuideView::mixtures
  typename L::Uint side;  ///< see guide_side()
  static constexpr auto fields(auto& s) { return std::tie(s.row, s.side); }
};

/// A ray towards a light, or from a photon's vertex towards the camera, with what it brings if nothing is in between.
template <class L> struct ShadowItem {
  Vec3<L> origin, direction;  ///< world space; direction not normalised: the light lies at distance 1
  Spectrum<L> contribution;   ///< radiance if unoccluded
  typename L::Uint slot;      ///< path this pays into
  typename L::Uint light;     ///< row of the light that it comes from
  static constexpr auto fields(auto& s) { return std::tie(s.origin, s.direction, s.contribution, s.slot, s.light); }
};

/// What a shadow ray needs besides where there are media or surfaces that let it pass; stands where its ShadowItem
/// stands, whose contribution is then without a weight against BSDF sampling.
template <class L> struct TransmittanceItem {
  Spectrum<L> r_u, r_l;         ///< as in RescaledPdfs: by BSDF sampling, by light sampling
  typename L::Float pdf_ratio;  ///< density of BSDF sampling over that of light sampling; 0: no contest
  typename L::Uint flags;       ///< as RayState::flags: lane and medium at the origin
  typename L::Uint
      target_medium;  ///< kNone; or the medium, 1 + its row, that the ray must end in, for light of its own
  static constexpr auto fields(auto& s) { return std::tie(s.r_u, s.r_l, s.pdf_ratio, s.flags, s.target_medium); }
};

}  // namespace sheaf
