// Samples ends of chains with the emission of photons, and evaluates the light that the chain's last ray reaches.
#include "kernels/caustics/chain_light.h"

#include "kernels/lights/light_sample.h"

#include <cmath>

namespace sheaf {

namespace {

/// Relative deviation of the distance at which the last ray hits the light from that of the sampled point.
constexpr float kDistanceError = 1e-3f;
/// Fraction of the distance to a light at a point that must be unoccluded.
constexpr float kOpenFraction = 0.9999f;
/// Assumed probability with which a walk finds a chain.
constexpr float kWalkProbability = 0.1f;

LightHitKind hit_kind(const LightRow& light) {
  LightHitKind kind = LightHitKind::kNever;
  Lights::for_each([&]<class Light>(Light) {
    if (light.is(kLightKind<typename Light::Kind>)) kind = Light::kHitKind;
  });
  return kind;
}

/// A light with its spectrum at `lambda`.
template <ColorMode kMode> LightRow light_at(const SceneView& scene, std::uint32_t row, const Spectrum4& lambda) {
  LightRow light = scene.lights.rows[row];
  if constexpr (kMode == ColorMode::kSpectral) light.radiance = light_spectra<Scalar>(scene, row, lambda);
  return light;
}

/// A point on an area light: the origin of a photon that leaves along the normal.
template <ColorMode kMode>
PhotonEmission<Scalar> point_on(const SceneView& scene, std::uint32_t row, const Spectrum4& lambda,
                                const Random4<Scalar>& u, float time) {
  const LightRow light = light_at<kMode>(scene, row, lambda);
  const Random4<Scalar> along_normal{0.5f, 0.5f, 0.75f, 0};
  PhotonEmission<Scalar> e{};
  TextureQuery<Scalar> query{};
  Lights::for_each([&]<class Light>(Light) {
    if (light.is(kLightKind<typename Light::Kind>))
      e = Light::template emit<Scalar, kMode>({scene, light, true, lambda, nullptr, time}, u, along_normal, query);
  });
  // Move it with the light, whose surface stretches
  if (scene.motion.lights == nullptr) return e;
  const MotionSample<Scalar> motion = light_motion<Scalar>(scene, row, true, time);
  if (!motion.moves) return e;
  e.origin = motion.placed.point(e.origin);
  e.pdf_position /= length(motion.placed.normal(e.direction));
  return e;
}

template <ColorMode kMode>
std::optional<ChainLight> sample_end(const SceneView& scene, const CausticCasters::Light& choice, Vec3f p, float time,
                                     const Spectrum4& lambda, const Random4<Scalar>& u) {
  if (hit_kind(scene.lights.rows[choice.row]) == LightHitKind::kSurface) {
    const PhotonEmission<Scalar> e = point_on<kMode>(scene, choice.row, lambda, u, time);
    if (!(e.pdf_position > 0) || !std::isfinite(e.pdf_position) || !is_finite(e.origin)) return {};
    return ChainLight{{e.origin, false}, choice.row, e.pdf_position * choice.probability};
  }
  const LightSample<Scalar> s = sample_light<Scalar, kMode>(scene, {p, {}}, {choice.row, 1}, u, time, lambda);
  const bool is_infinite = choice.row >= scene.lights.bounded_count;
  return ChainLight{{is_infinite ? s.direction : s.target, is_infinite}, choice.row, choice.probability};
}

/// Radiance times cosine at the point of an area light that the last ray of a chain reaches.
template <ColorMode kMode>
Spectrum4 area_light_arriving(ChainTracer& tracer, const SceneView& scene, const CausticCasters& casters,
                              const ChainLight& end, const ConnectedChain& chain, float first_cosine,
                              const Spectrum4& lambda) {
  const Vec3f from = chain.origin;
  const Vec3f to = end.target.position - from;
  const float distance = length(to);
  const Vec3f direction = to / distance;
  const SurfaceHit hit = tracer.intersect(from, direction);
  if (hit.shape == kNone || !(std::fabs(hit.t - distance) <= kDistanceError * distance)) return {};
  const ShapeRow& shape = scene.geometry.shapes[hit.shape];
  if (shape.light == kNone) return {};
  const std::uint32_t first = hit.instance == kNone ? 0 : scene.geometry.instances[hit.instance].first_light;
  if (shape.light + first != end.light) return {};
  // Evaluate the emitted radiance, as the emission stage does
  const auto y = surface_point<Scalar, true>(scene, shape, hit.primitive, hit.u, hit.v, from + direction * hit.t,
                                             hit.instance, tracer.time());
  const LightRow light = light_at<kMode>(scene, end.light, lambda);
  const float cosine = -dot(direction, y.ng);
  if (!(cosine > 0) && !light.is_two_sided()) return {};
  const TextureQuery<Scalar> query{y.uv, hit.shape, hit.primitive, hit.u, hit.v};
  Spectrum4 texture = light_textures<Scalar, kMode>(scene, light.texture, true, query, lambda);
  if (scene.lights.coats != nullptr) texture = texture * coat_transmittance<Scalar>(scene, light, true, cosine, query);
  const float by_bsdf =
      chain_bsdf_weight(scene, casters, {from, direction, hit.t, y.ng, end.light, hit.primitive, tracer.time()},
                        chain.solid_angle_ratio, first_cosine);
  return light.radiance * texture * (std::fabs(cosine) * (1 - by_bsdf));
}

template <ColorMode kMode>
Spectrum4 arriving(ChainTracer& tracer, const SceneView& scene, const CausticCasters& casters, const ChainLight& end,
                   const ConnectedChain& chain, float cosine, const Spectrum4& lambda) {
  if (hit_kind(scene.lights.rows[end.light]) == LightHitKind::kSurface)
    return area_light_arriving<kMode>(tracer, scene, casters, end, chain, cosine, lambda);
  const Vec3f from = chain.origin;
  const LightSample<Scalar> s =
      sample_light<Scalar, kMode>(scene, {from, {}}, {end.light, 1}, {}, tracer.time(), lambda);
  if (!s.valid) return {};
  const Vec3f to = s.target - from;
  if (!tracer.is_open(from, to * kOpenFraction)) return {};
  // Lights at a point: from intensity over squared distance to intensity.
  return s.radiance * (end.target.is_infinite ? 1.0f : dot(to, to));
}

}  // namespace

std::optional<ChainLight> sample_chain_light(const SceneView& scene, const CausticCasters& casters, Vec3f p, float time,
                                             const Spectrum4& lambda, MediumRandom& random) {
  const CausticCasters::Light choice = casters.sample_light(random.next());
  const Random4<Scalar> u{random.next(), random.next(), random.next(), random.next()};
  return scene.color == ColorMode::kSpectral ? sample_end<ColorMode::kSpectral>(scene, choice, p, time, lambda, u)
                                             : sample_end<ColorMode::kRgb>(scene, choice, p, time, lambda, u);
}

Spectrum4 arriving_light(ChainTracer& tracer, const SceneView& scene, const CausticCasters& casters,
                         const ChainLight& end, const ConnectedChain& chain, float cosine, const Spectrum4& lambda) {
  const Spectrum4 at_end = scene.color == ColorMode::kSpectral
                               ? arriving<ColorMode::kSpectral>(tracer, scene, casters, end, chain, cosine, lambda)
                               : arriving<ColorMode::kRgb>(tracer, scene, casters, end, chain, cosine, lambda);
  return at_end * (chain.solid_angle_ratio / end.pdf);
}

float chain_bsdf_weight(const SceneView& scene, const CausticCasters& casters, const ChainEnd& end, float ratio,
                        float cosine) {
  const LightRow& light = scene.lights.rows[end.light];
  // Both densities per solid angle of the last ray
  const float by_walk =
      kWalkProbability * casters.light_probability(end.light) *
      light_pdf_solid_angle<Scalar>(scene, end.light, light, true,
                                    {end.from, end.direction, end.t, end.ng, end.primitive}, end.time);
  const float by_bsdf = cosine * kInvPi * ratio * end.t * end.t;
  if (!(by_walk > 0)) return 1;
  const float pdf_ratio = by_bsdf / by_walk;
  return std::isfinite(pdf_ratio) ? pdf_ratio * pdf_ratio / (1 + pdf_ratio * pdf_ratio) : 1.0f;
}

}  // namespace sheaf
