// The state of a path that stages pass on to each other, and the columns of vertices and shadow rays. Each of the four
// path records takes 32 bytes and is addressed by slot (kernels/wave/slot_table.h).
#pragma once

#include "core/color/spectrum.h"
#include "kernels/wave/slot_table.h"
#include "scene/tables/material.h"

namespace sheaf {

/// The ray to be traced next.
template <class L> struct RayState {
  Vec3<L> origin;
  typename L::Float t_max;  ///< maximum distance
  Vec3<L> direction;        ///< normalized
  typename L::Uint flags;   ///< RayFlags
  static constexpr auto fields(auto& s) { return std::tie(s.origin, s.t_max, s.direction, s.flags); }
};

/// Bits of RayState::flags. Bits 4 and 5 hold the hero lane, whose extinction is used to sample distances in media.
/// Bits 8 and above hold the medium that the ray is in: 0 for vacuum, otherwise 1 + its row.
enum RayFlags : std::uint32_t {
  kRayFromCamera = 1,  ///< only null interfaces lie between the camera and the origin
  kRayLast = 2,        ///< max_depth is reached: the hit may emit but does not scatter
  kRayFromMedium = 4,  ///< the previous vertex lies in a medium
  // History of the path, for photon maps.
  /// Camera paths: a non-delta lobe of a surface has scattered the path. Photons: the same, or a medium has.
  kRayDiffuse = 8,
  kRaySpecular = 64,            ///< photons: a delta lobe has scattered the path
  kRayScatteredInMedium = 128,  ///< camera paths: scattered in a medium since kRayDiffuse was set
};
/// The same three bits, in passes that connect paths to lights by specular chains: see kernels/stages/chain_state.h.
inline constexpr std::uint32_t kRayHistory = kRayDiffuse | kRaySpecular | kRayScatteredInMedium;
inline constexpr int kRayHeroShift = 4, kRayMediumShift = 8;
inline constexpr std::uint32_t kRayHeroMask = 3u << kRayHeroShift;

/// The intersection of a ray, or the point where a medium scatters it.
template <class L> struct HitState {
  typename L::Float t;         ///< distance, m
  typename L::Float u, v;      ///< barycentric coordinates
  typename L::Uint primitive;  ///< triangle of the shape
  typename L::Uint shape;
  typename L::Uint instance;
  typename L::Uint material;  ///< row for the side of the surface that was hit
  typename L::Uint light;     ///< row; kNone: does not emit
  static constexpr auto fields(auto& s) {
    return std::tie(s.t, s.u, s.v, s.primitive, s.shape, s.instance, s.material, s.light);
  }
};

/// Throughput of a path, and the sample that it belongs to.
template <class L> struct PathState {
  Spectrum<L> beta;  ///< throughput; radiance is divided by the mean of RescaledPdfs::r_u as well
  /// Squared relative index of refraction along the path; Russian roulette ignores it.
  typename L::Float eta_scale;
  typename L::Uint depth_and_dimension;  ///< depth() in the lower 16 bits, dimension() in the upper 16
  typename L::Uint pixel;                ///< y * frame width + x; photons: see kPhotonPixel
  typename L::Uint sample;               ///< index among all samples of the pixel
  static constexpr auto fields(auto& s) {
    return std::tie(s.beta, s.eta_scale, s.depth_and_dimension, s.pixel, s.sample);
  }

  /// Vertices that cost depth.
  SHEAF_INLINE typename L::Uint depth() const { return depth_and_dimension & typename L::Uint(0xffffu); }
  /// Index of the next block of random numbers; each interaction uses one.
  SHEAF_INLINE typename L::Uint dimension() const { return depth_and_dimension >> 16; }
};
inline constexpr std::uint32_t kOneDepth = 1u, kOneDimension = 1u << 16;
/// Largest depth and dimension: neither overflows into the bits of the other. Paths that reach it are terminated.
inline constexpr std::uint32_t kLongestPath = 0x7fffu;

/// Radiance that a path has collected, and data of its previous vertex for MIS.
template <class L> struct RadianceState {
  Spectrum<L> radiance;           ///< so far
  typename L::Float scatter_pdf;  ///< solid-angle pdf of the ray, 1/sr; 0: camera ray or delta lobe
  typename L::Uint normal;        ///< octahedral shading normal of the previous vertex, for light selection
  typename L::Float weight;       ///< pixel filter weight of the sample; photons: flux, W
  typename L::Uint task_sample;   ///< index into the task's sample buffer, and kTransparent
  static constexpr auto fields(auto& s) {
    return std::tie(s.radiance, s.scatter_pdf, s.normal, s.weight, s.task_sample);
  }
};
/// Bit of RadianceState::task_sample: the camera ray hit nothing visible, so the sample's alpha is 0.
inline constexpr std::uint32_t kTransparent = 0x80000000u;

/// Rescaled path pdfs per lane. Lane k holds the pdf of the path with lane k as the hero lane, over the pdf by which
/// the throughput was divided (Miller, Georgiev and Jarosz, "A Null-Scattering Path Integral Formulation of Light
/// Transport", 2019; rescaled as in PBR 14.2.1). Allocated only with SceneView::needs_transmittance.
template <class L> struct RescaledPdfs {
  Spectrum<L> r_u;  ///< unidirectional sampling
  Spectrum<L> r_l;  ///< unidirectional up to the last vertex, light sampling from there
  static constexpr auto fields(auto& s) { return std::tie(s.r_u, s.r_l); }
};

/// The ray from the last non-specular vertex of a camera path, from which specular chains start. Valid while
/// kernels/stages/chain_state.h says so.
template <class L> struct ChainStartState {
  Vec3<L> origin;
  typename L::Float cosine;    ///< absolute, to the geometric normal of the vertex
  Vec3<L> direction;           ///< unit length
  typename L::Uint refracted;  ///< see ChainType::refracted
  static constexpr auto fields(auto& s) { return std::tie(s.origin, s.cosine, s.direction, s.refracted); }
};

/// The segment of a ray in a medium on which the last vertex of a path lies.
template <class L> struct SegmentState {
  Vec3<L> origin;
  typename L::Float length;     ///< m
  Vec3<L> direction;            ///< unit length
  typename L::Float pdf_ratio;  ///< 1 over the mean pdf of the vertex's distance, m; 0: the segment is not connected
  static constexpr auto fields(auto& s) { return std::tie(s.origin, s.length, s.direction, s.pdf_ratio); }
};

/// A vertex ready for shading. Rows are in the order of closure kinds.
template <class L> struct VertexItem {
  Vec3<L> p;                 ///< world space
  Vec3<L> ng;                ///< geometric normal, unit length
  Vec3<L> ns;                ///< shading normal, unit length; two-sided: faces the viewer
  Vec3<L> wo;                ///< direction to the previous vertex, in the shading frame
  typename L::Float offset;  ///< see SurfacePoint::offset
  Vec2<L> tangent;           ///< x axis of the shading frame, see ShadingFrame; anisotropic closures only
  static constexpr auto fields(auto& s) { return std::tie(s.p, s.ng, s.ns, s.wo, s.offset, s.tangent); }
};

/// Inputs of textures and normal maps at a surface vertex. Only for materials with kNeedsUv.
template <class L> struct TexturedItem {
  Vec2<L> uv;
  Vec3<L> dp_du, dp_dv;             ///< derivatives of the position
  Vec3<L> ns_unmapped;              ///< VertexItem::ns before normal mapping
  typename L::Float handedness;     ///< -1 if ns was flipped towards the viewer, otherwise 1
  typename L::Float terminator;     ///< squared roughness of shadow_terminator()
  typename L::Float normal_choice;  ///< photons only, see matches_normal_choice()
  Vec2<L> footprint;                ///< TextureQuery::footprint
  Vec2<L> footprint_axis;           ///< TextureQuery::footprint_axis
  static constexpr auto fields(auto& s) {
    return std::tie(s.uv, s.dp_du, s.dp_dv, s.ns_unmapped, s.handedness, s.terminator, s.normal_choice, s.footprint,
                    s.footprint_axis);
  }
};

/// Parameters of a closure. Only as many words as its kind needs are valid.
template <class L> struct ClosureItem {
  typename L::Float words[kMaxClosureWords];
  static constexpr auto fields(auto& s) { return std::tie(s.words); }
};

/// A sampled light, before visibility is tested. Same row as its VertexItem.
template <class L> struct LightCandidate {
  Vec3<L> direction;                  ///< towards the light, unit length
  Vec3<L> target;                     ///< end of the shadow ray
  Spectrum<L> radiance;               ///< see LightSample::radiance
  typename L::Float pdf_solid_angle;  ///< see LightSample::pdf_solid_angle, 1/sr; 0: no light arrives
  typename L::Float delta;            ///< 1: BSDF sampling cannot find this light; otherwise 0
  typename L::Uint light;             ///< row
  typename L::Uint target_medium;     ///< see TransmittanceItem::target_medium
  static constexpr auto fields(auto& s) {
    return std::tie(s.direction, s.target, s.radiance, s.pdf_solid_angle, s.delta, s.light, s.target_medium);
  }
};

/// Reservoir of resampled importance sampling. Same row as its VertexItem.
template <class L> struct ReservoirItem {
  Vec3<L> target;                  ///< of the kept candidate
  Spectrum<L> contribution;        ///< unoccluded radiance of the kept candidate over its pdf
  typename L::Float weight;        ///< its resampling weight: lanes of `contribution` added up, MIS-weighted
  typename L::Float sum;           ///< sum of the weights of all candidates
  typename L::Float u;             ///< uniform in [0, 1), for the next selection
  typename L::Float pdf_ratio;     ///< see TransmittanceItem::pdf_ratio
  typename L::Uint light;          ///< row
  typename L::Uint target_medium;  ///< see TransmittanceItem::target_medium
  typename L::Uint single;         ///< 1: only the first of four wavelengths reaches the target; otherwise 0
  static constexpr auto fields(auto& s) {
    return std::tie(s.target, s.contribution, s.weight, s.sum, s.u, s.pdf_ratio, s.light, s.target_medium, s.single);
  }
};

/// Film position where the camera sees a vertex of a photon. Same row as its VertexItem.
template <class L> struct RasterPosition {
  typename L::Float x, y;  ///< pixels
  static constexpr auto fields(auto& s) { return std::tie(s.x, s.y); }
};

/// The cell of the guide that a vertex lies in. Same row as its VertexItem.
template <class L> struct GuideCell {
  typename L::Uint row;   ///< of GuideView::mixtures
  typename L::Uint side;  ///< see guide_side()
  static constexpr auto fields(auto& s) { return std::tie(s.row, s.side); }
};

/// A ray towards a light, or from a photon's vertex towards the camera.
template <class L> struct ShadowItem {
  Vec3<L> origin, direction;  ///< world space; direction not normalized: the target is at t = 1
  Spectrum<L> contribution;   ///< radiance if unoccluded
  typename L::Uint slot;      ///< path that receives the radiance
  typename L::Uint light;     ///< row of the light that is sampled
  static constexpr auto fields(auto& s) { return std::tie(s.origin, s.direction, s.contribution, s.slot, s.light); }
};

/// State of a shadow ray besides its ShadowItem in scenes with SceneView::needs_transmittance. Same row as its
/// ShadowItem, whose contribution does not include the MIS weight then.
template <class L> struct TransmittanceItem {
  Spectrum<L> r_u, r_l;         ///< see RescaledPdfs: by BSDF sampling, by light sampling
  typename L::Float pdf_ratio;  ///< BSDF pdf over the pdf of light sampling; 0: light sampling only
  typename L::Uint flags;       ///< hero lane and medium at the origin as in RayState::flags, and ShadowFlags
  /// 1 + row of the emissive medium that the ray must end in, if the target is a point in a medium; otherwise kNone.
  typename L::Uint target_medium;
  static constexpr auto fields(auto& s) { return std::tie(s.r_u, s.r_l, s.pdf_ratio, s.flags, s.target_medium); }
};

}  // namespace sheaf
