// What a kind of light says of itself, and what it is asked: the common ground of the files of single kinds, of which
// kernels/lights/all.h is the list.
//
// A kind is a struct of static functions, all generic in the lane. It says which LightKind it is and how a path may
// meet it without having sampled it, and defines
//     sample    a direction towards the light and what arrives from there,
//     emit      a photon that leaves it,
// and, as paths may meet it,
//     kNever    nothing,
//     kSurface  pdf_solid_angle: the density with which sample() finds a point of it that a ray has hit,
//     kEscape   arriving: what comes from a direction, with that density,
//     kMedium   pdf_volume: that density at a point.
// Lanes of a register may hold lights of several kinds: what is computed for the lanes of others is dropped, so it may
// be anything, but must not read from rows that there are not.
#pragma once

#include "core/rng.h"
#include "core/warp.h"
#include "kernels/lights/envmap.h"
#include "scene/tables/scene.h"
#include "scene/tables/texture_lookup.h"

#include <concepts>

namespace sheaf {

/// How paths meet lights by sampling BSDFs and phase functions.
enum class LightHitKind {
  kNever,    ///< a single point or direction
  kSurface,  ///< by hitting a shape
  kEscape,   ///< by leaving the scene
  kMedium,   ///< by passing a medium
};

/// The rows lights[light], one for each lane.
template <class L> SHEAF_INLINE LightRecord<L> load_lights(const SceneView& scene, typename L::Uint light) {
  return scene.light_count == 1 ? spread_row<L>(scene.lights[0]) : gather_rows<L>(scene.lights, light);
}

/// Lights that are asked, one for each lane.
template <class L> struct LightQuery {
  const SceneView& scene;
  const LightRecord<L>& light;  ///< spectral mode: with its radiance at `lambda`
  Mask<L> active;               ///< lanes whose light is of the kind that is asked
  const Spectrum<L>& lambda;    ///< spectral mode: wavelengths, nm
  /// What u.y and u.z have drawn from the environment map, if that is known already, or null.
  const EnvmapDraw<L>* drawn = nullptr;
};

/// Light that arrives at a reference point from a sampled direction.
template <class L> struct LightSample {
  Vec3<L> direction;     ///< from the reference point, unit length
  Vec3<L> target;        ///< where the shadow ray ends: on the light, moved off its surface
  Spectrum<L> radiance;  ///< incident radiance; point lights: intensity over squared distance
  /// Where the light is a single direction, the probability: 1; in a volume, solid angle times length.
  typename L::Float pdf_solid_angle;
  typename L::Mask delta;          ///< BSDF sampling cannot find this light; kinds leave it to who asks
  typename L::Mask valid;          ///< false: nothing arrives
  typename L::Uint target_medium;  ///< see TransmittanceItem::target_medium; kinds leave it to who asks
};

/// A point of an area light that a ray from a reference point has hit.
template <class L> struct LightHit {
  Vec3<L> from, direction;  ///< the ray; unit length
  typename L::Float t;      ///< distance
  Vec3<L> ng;               ///< geometric normal of the light there
};

/// A photon as it leaves a light. The mean of `flux` over all of them is the power of all lights, and the flux of those
/// that cross a surface the power that arrives there.
template <class L> struct PhotonEmission {
  Vec3<L> origin;     ///< world space; off the surface of an area light, and outside of the scene for infinite lights
  Vec3<L> direction;  ///< in which the photon travels, unit length
  Spectrum<L> flux;   ///< W; divided by both densities and by the probability of the light
  /// Per area: on the light's surface, or on the disk that infinite lights shine through. Media: per volume. Lights at
  /// a point: 1.
  typename L::Float pdf_position;
  typename L::Float pdf_direction;  ///< per solid angle; for a single direction 1
  typename L::Mask valid;           ///< false: there is no photon
  /// Photons of a medium: 1 + its row, as in ray flags. Where the first surface that such a photon meets says that it
  /// comes from another medium, the point lay outside, and there is no photon. Other lights: kNone, as they don't know
  /// what they are in.
  typename L::Uint medium;
};

/// Fills the lanes of `m`.
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
  { Kind::kKind } -> std::convertible_to<LightKind>;
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
concept FillsVolume = requires(const SceneView& scene, std::uint32_t light, Vec3f p) {
  { Kind::pdf_volume(scene, light, p) } -> std::same_as<float>;
};

}  // namespace light_kind_detail

/// A kind that defines all that it must, and nothing that its way of being met has no use for.
template <class Kind>
concept LightModel = light_kind_detail::Samples<Kind> &&
                         (Kind::kHitKind == LightHitKind::kSurface) == light_kind_detail::LiesOnSurface<Kind> &&
                     (Kind::kHitKind == LightHitKind::kEscape) == light_kind_detail::SurroundsScene<Kind> &&
                     (Kind::kHitKind == LightHitKind::kMedium) == light_kind_detail::FillsVolume<Kind>;

}  // namespace sheaf
