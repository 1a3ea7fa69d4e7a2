// The interface of a light kind, and its argument and result types.
//
// A kind is a struct of static functions that are generic in the lane policy. It names its scene half (Kind, one of
// scene/lights/list.h) and how a path may hit it without light sampling (LightHitKind). It defines
//     sample    sample a direction to the light, and the radiance that arrives from there,
//     emit      emit a photon,
// and depending on LightHitKind
//     kNever    nothing,
//     kSurface  pdf_solid_angle: the pdf with which sample() returns a point that a ray has hit,
//     kEscape   arriving: the radiance from a direction, and that pdf,
//     kMedium   pdf_volume: that pdf at a point, and medium: the row of the medium.
// and optionally, as constants that are true
//     kIsSampledInline  for common kinds: light sampling inlines their code for registers with lights of one kind,
//     kIsForPhotons     light sampling never reaches the light.
// A specialization of LightOf below the struct makes it the kernel of its scene half.
//
// The lanes of a register may hold lights of several kinds. A kind may compute anything in the lanes of other kinds,
// since those results are discarded, but it must not read rows that do not exist.
#pragma once

#include "core/sampling/rng.h"
#include "core/sampling/warp.h"
#include "kernels/lights/envmap.h"
#include "scene/tables/scene_view.h"
#include "scene/textures/texture_lookup.h"

#include <concepts>

namespace sheaf {

/// Hits of lights by paths that sample BSDFs and phase functions.
enum class LightHitKind {
  kNever,    ///< not at all: the light is a single point or direction
  kSurface,  ///< by hitting a shape
  kEscape,   ///< by leaving the scene
  kMedium,   ///< by passing through a medium
};

/// `Type` is the kernel of a kind of scene/lights/list.h. Each kernel specializes it beside its definition.
template <class Kind> struct LightOf;

/// Loads the rows lights[light], one per lane.
template <class L> SHEAF_INLINE LightRecord<L> load_lights(const SceneView& scene, typename L::Uint light) {
  return scene.lights.count == 1 ? spread_row<L>(scene.lights.rows[0]) : gather_rows<L>(scene.lights.rows, light);
}

/// The lights to evaluate, one per lane.
template <class L> struct LightQuery {
  const SceneView& scene;
  const LightRecord<L>& light;  ///< spectral mode: with its radiance at `lambda`
  Mask<L> active;               ///< lanes whose light is of the kind being called
  const Spectrum<L>& lambda;    ///< spectral mode: wavelengths, nm
  /// Cell that u.y and u.z have already sampled from the environment map, or null.
  const EnvmapDraw<L>* drawn = nullptr;
  Float<L> time{};  ///< in [0, 1]; for meshes that deform
  /// Shading normal of the point to be lit, or 0 if light counts from all directions. sample() and pdf_solid_angle()
  /// must get the same, since kinds may sample by its cosine.
  Vec3<L> normal{};
};

/// Light that arrives at a reference point from a sampled direction.
template <class L> struct LightSample {
  Vec3<L> direction;     ///< from the reference point, unit length
  Vec3<L> target;        ///< end of the shadow ray: on the light, offset from its surface
  Spectrum<L> radiance;  ///< incident radiance; point lights: intensity over squared distance
  /// Pdf per solid angle. Lights at a point or in one direction: 1. Volume lights: per solid angle and length.
  typename L::Float pdf_solid_angle;
  typename L::Mask delta;          ///< BSDF sampling cannot hit this light; set by the caller of the kind
  typename L::Mask valid;          ///< false: no light arrives
  typename L::Uint target_medium;  ///< see TransmittanceItem::target_medium; set by the caller of the kind
  Vec3<L> normal{};                ///< area lights: geometric normal at the target; any length
};

/// A point on an area light that a ray has hit.
template <class L> struct LightHit {
  Vec3<L> from, direction;       ///< the ray; unit length
  typename L::Float t;           ///< distance
  Vec3<L> ng;                    ///< geometric normal of the light at the hit point
  typename L::Uint primitive{};  ///< triangle of the light; for meshes that deform
  Vec3<L> normal{};              ///< at `from`; see LightQuery
};

/// A photon emitted by a light. The mean of `flux` over all photons is the total power of the lights; the flux of the
/// photons that cross a surface is the power that arrives there.
template <class L> struct PhotonEmission {
  /// world space; offset from the surface of area lights, outside the scene for lights at infinity
  Vec3<L> origin;
  Vec3<L> direction;  ///< direction of travel, unit length
  Spectrum<L> flux;   ///< W; divided by both pdfs and by the probability of the light
  /// Per area: on the light's surface, or on the disk that lights at infinity shine through. Volume lights: per volume.
  /// Lights at a point: 1.
  typename L::Float pdf_position;
  typename L::Float pdf_direction;  ///< per solid angle; 1 for a single direction
  typename L::Mask valid;           ///< false: no photon was emitted
  /// Volume lights: 1 + the row of the medium, as in ray flags. If the first surface that the photon hits belongs to
  /// another medium, its origin lay outside the medium and the photon is discarded. Other lights: kNone, because they
  /// do not know the medium around them.
  typename L::Uint medium;
  Vec3<L> normal{};  ///< area lights: geometric normal at the origin; any length
};

/// Copies `a` to the lanes of `m`.
template <class L> SHEAF_INLINE void set_query(Mask<L> m, const TextureQuery<L>& a, TextureQuery<L>& into) {
  into.uv = {select(m, a.uv.x, into.uv.x), select(m, a.uv.y, into.uv.y)};
  into.shape = select(m, a.shape, into.shape);
  into.primitive = select(m, a.primitive, into.primitive);
  into.b1 = select(m, a.b1, into.b1);
  into.b2 = select(m, a.b2, into.b2);
}

namespace light_kind_detail {

template <class Kind>
concept Samples = requires(const LightQuery<Scalar>& lights, Vec3f from, const Random4<Scalar>& u,
                           TextureQuery<Scalar>& texture) {
  typename Kind::Kind;
  { Kind::kHitKind } -> std::convertible_to<LightHitKind>;
  { Kind::template sample<Scalar, ColorMode::kRgb>(lights, from, u, texture) } -> std::same_as<LightSample<Scalar>>;
  { Kind::template emit<Scalar, ColorMode::kRgb>(lights, u, u, texture) } -> std::same_as<PhotonEmission<Scalar>>;
};

template <class Kind>
concept LiesOnSurface = requires(const LightQuery<Scalar>& lights, const LightHit<Scalar>& hit) {
  { Kind::template pdf_solid_angle<Scalar>(lights, hit) } -> std::same_as<float>;
};

template <class Kind>
concept SurroundsScene = requires(const SceneView& scene, const LightRow& light, const Spectrum4& emitted,
                                  Vec3f direction) {
  {
    Kind::template arriving<Scalar, ColorMode::kRgb>(scene, light, emitted, direction, emitted)
    } -> std::same_as<EnvmapValue<Scalar>>;
};

template <class Kind>
concept FillsVolume = requires(const SceneView& scene, std::uint32_t light, const LightRow& row, Vec3f p) {
  { Kind::pdf_volume(scene, light, p) } -> std::same_as<float>;
  { Kind::template medium<Scalar>(row) } -> std::same_as<std::uint32_t>;
};

}  // namespace light_kind_detail

/// Whether a kind has kIsSampledInline.
template <class Light> inline constexpr bool kIsSampledInline = requires { Light::kIsSampledInline; };
/// Whether a kind has kIsForPhotons.
template <class Light> inline constexpr bool kIsForPhotons = requires { Light::kIsForPhotons; };

/// A valid light kind: it defines everything that its LightHitKind requires, and nothing else.
template <class Kind>
concept LightModel = light_kind_detail::Samples<Kind> &&
                         (Kind::kHitKind == LightHitKind::kSurface) == light_kind_detail::LiesOnSurface<Kind> &&
                     (Kind::kHitKind == LightHitKind::kEscape) == light_kind_detail::SurroundsScene<Kind> &&
                     (Kind::kHitKind == LightHitKind::kMedium) == light_kind_detail::FillsVolume<Kind>;

}  // namespace sheaf
