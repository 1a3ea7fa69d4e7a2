// Stage: emission. Rays that left the scene meet the environment; rays that hit an area light collect its radiance.
// Both are weighted by multiple importance sampling against what light_candidates would have done.
#include "core/octahedral.h"
#include "kernels/light_sample.h"
#include "kernels/light_weight.h"
#include "kernels/path_wavelengths.h"
#include "kernels/stage_timer.h"
#include "kernels/stages.h"

namespace sheaf {

namespace {

/// Weight of light found by BSDF sampling with density `scatter_pdf` (0: specular or camera, counts in full).
template <class L>
SHEAF_INLINE Float<L> emission_weight(const IntegratorDescription& settings, Float<L> scatter_pdf, Float<L> light_pdf) {
  using F = Float<L>;
  const auto specular = scatter_pdf == F(0.0f);
  if (settings.strategy == LightStrategy::kBsdfOnly) return F(1.0f);
  if (settings.strategy == LightStrategy::kLightOnly) return select(specular, F(1.0f), F(0.0f));
  const F share = bsdf_weight(light_pdf, select(specular, F(1.0f), scatter_pdf), settings.candidates);
  return select(specular, F(1.0f), share);
}

/// The vertex that a ray comes from, as light_candidates saw it, and what the ray has met since.
template <class L> struct LightPath {
  LightReceiver<L> receiver;
  typename L::Float travelled;  ///< from the vertex to the ray's origin
  typename L::Float rivals;     ///< probability of light sampling to come this way over that of BSDF sampling
  typename L::Float divisor;    ///< mean over the lanes of the path's probabilities
};

/// Scenes with media or surfaces that let shadow rays pass: see ProbabilityState.
template <class L>
void follow_probabilities(const SceneView& scene, const Wave& wave, const Slot* slots, const RayState<L>& ray,
                          LightPath<L>& path) {
  using F = Float<L>;
  const ProbabilityState<L> r = wave.probabilities.gather<L>(slots);
  const auto mean = [&](const Spectrum<L>& lanes) {
    return scene.color == ColorMode::kSpectral ? total(lanes) * F(0.25f)
                                               : (lanes.c0 + lanes.c1 + lanes.c2) * F(1.0f / 3.0f);
  };
  path.divisor = mean(r.r_u);
  path.rivals = mean(r.r_l) / path.divisor;
  alignas(kSimdAlignment) float travelled[L::width];
  for (int lane = 0; lane < L::width; ++lane) travelled[lane] = wave.travelled[slots[lane]];
  load(travelled, path.travelled);
  path.receiver.p = ray.origin - ray.direction * path.travelled;
  const auto in_medium = (ray.flags & Uint<L>(kRayFromMedium)) != Uint<L>(0u);
  path.receiver.n = select<L>(in_medium, Vec3<L>{}, path.receiver.n);
}

template <class L>
SHEAF_INLINE LightPath<L> light_path(const SceneView& scene, const Wave& wave, const Slot* slots, const RayState<L>& ray,
                                     const RadianceState<L>& radiance) {
  using F = Float<L>;
  LightPath<L> path{{ray.origin, decode_octahedral<L>(radiance.normal)}, F(0.0f), F(1.0f), F(1.0f)};
  if (scene.has_transparency) follow_probabilities<L>(scene, wave, slots, ray, path);
  return path;
}

/// Radiance of the environment, and the density of sampling it.
template <class L, ColorMode Mode>
SHEAF_INLINE EnvmapValue<L> environment_value(const SceneView& scene, Vec3<L> direction, const Spectrum<L>& lambda) {
  using F = Float<L>;
  const LightRow& light = scene.lights[scene.environment];
  const bool is_map = light.kind == static_cast<std::uint32_t>(LightKind::kEnvmap);
  if constexpr (Mode == ColorMode::kSpectral) {
    const Spectrum<L> emitted = light_spectra<L>(scene, Uint<L>(scene.environment), lambda);
    if (!is_map) return {emitted, F(kUniformSpherePdf)};
    const auto found = lookup_envmap<L, Mode>(scene.envmap, direction, lambda);
    return {found.radiance * emitted, found.pdf_solid_angle};
  }
  if (is_map) return lookup_envmap<L>(scene.envmap, direction);
  return {{F(light.radiance[0]), F(light.radiance[1]), F(light.radiance[2]), F(light.radiance[3])}, F(kUniformSpherePdf)};
}

template <class L, ColorMode Mode>
SHEAF_INLINE void environment_tile(const SceneView& scene, Wave& wave, const Slot* slots, int count) {
  using F = Float<L>;
  using U = Uint<L>;
  RadianceState<L> radiance = wave.radiance.gather<L>(slots);
  const RayState<L> ray = wave.rays.gather<L>(slots);
  const auto from_camera = (ray.flags & U(kRayFromCamera)) != U(0u);
  const bool visible = scene.environment != kNone;
  const auto shown = Mask<L>(visible) & !(from_camera & Mask<L>(scene.integrator.hide_emitters));
  radiance.task_sample = radiance.task_sample | select(from_camera & !shown, U(kTransparent), U(0u));
  if (visible) {
    const ThroughputState<L> path = wave.throughput.gather<L>(slots);
    const EnvmapValue<L> arriving =
        environment_value<L, Mode>(scene, ray.direction, shading_wavelengths<L, Mode>(wave, slots));
    const LightPath<L> from = light_path<L>(scene, wave, slots, ray, radiance);
    const F probability = choice_probability<L>(scene, from.receiver, U(scene.environment));
    const F weight = emission_weight<L>(scene.integrator, radiance.scatter_pdf,
                                        probability * arriving.pdf_solid_angle * from.rivals) / from.divisor;
    radiance.radiance = select<L>(shown, radiance.radiance + path.beta * arriving.radiance * weight, radiance.radiance);
  }
  wave.radiance.scatter<L>(slots, count, radiance);
}

/// `Textured`: some light may have a texture.
template <class L, ColorMode Mode, bool Textured>
SHEAF_INLINE void area_light_tile(const SceneView& scene, Wave& wave, const Slot* slots, int count) {
  using F = Float<L>;
  using U = Uint<L>;
  RayState<L> ray = wave.rays.gather<L>(slots);
  const HitState<L> hit = wave.hits.gather<L>(slots);
  const ThroughputState<L> path = wave.throughput.gather<L>(slots);
  RadianceState<L> radiance = wave.radiance.gather<L>(slots);
  const ShapeLanes<L> shape = load_shapes<L>(scene, hit.shape);
  const auto y = surface_point<L, Textured>(scene, shape, hit.primitive, hit.u, hit.v,
                                            ray.origin + ray.direction * hit.t, hit.instance);
  LightLanes<L> light = load_lights<L>(scene, hit.light);
  const Spectrum<L> lambda = shading_wavelengths<L, Mode>(wave, slots);
  if constexpr (Mode == ColorMode::kSpectral) light.radiance = light_spectra<L>(scene, hit.light, lambda);
  if constexpr (Textured)
    light.radiance = light.radiance * light_textures<L, Mode>(scene, light.texture, L::first(count),
                                                              {y.uv, hit.shape, hit.primitive, hit.u, hit.v}, lambda);

  const auto from_camera = (ray.flags & U(kRayFromCamera)) != U(0u);
  const auto hidden = from_camera & Mask<L>(scene.integrator.hide_emitters);
  const auto lit = (dot(ray.direction, y.ng) < F(0.0f)) & !hidden;
  const LightPath<L> from = light_path<L>(scene, wave, slots, ray, radiance);
  const F pdf = choice_probability<L>(scene, from.receiver, hit.light) *
                light_pdf_solid_angle<L>(scene, light, Mask<L>(true), from.receiver.p, ray.direction,
                                         hit.t + from.travelled, y.ng);
  const F weight = emission_weight<L>(scene.integrator, radiance.scatter_pdf, pdf * from.rivals) / from.divisor;
  radiance.radiance = select<L>(lit, radiance.radiance + path.beta * light.radiance * weight, radiance.radiance);
  wave.radiance.scatter<L>(slots, count, radiance);

  const std::uint32_t passing = mask_bits(hidden & L::first(count));
  if (passing == 0) return;
  ray.origin = select<L>(hidden, offset_origin<L>(y.p, y.ng, y.offset, ray.direction), ray.origin);
  wave.rays.scatter<L>(slots, count, ray);
  wave.active.push(slots, passing);
}

}  // namespace

template <class L> void emission(const SceneView& scene, Wave& wave) noexcept {
  const int misses = wave.miss.size(), lights = wave.emitter.size();
  if (misses + lights == 0) return;
  StageTimer timer(wave.stats, Stage::kEmission);
  timer.count(misses, L::width);
  timer.count(lights, L::width);
  wave.miss.pad();
  wave.emitter.pad();
  with_color_mode(scene, [&]<ColorMode Mode>() {
    for_tiles<L>(misses, [&](int i, int count) { environment_tile<L, Mode>(scene, wave, wave.miss.data() + i, count); });
    for_tiles<L>(lights, [&](int i, int count) {
      const Slot* slots = wave.emitter.data() + i;
      if (scene.has_textured_lights) {
        area_light_tile<L, Mode, true>(scene, wave, slots, count);
      } else {
        area_light_tile<L, Mode, false>(scene, wave, slots, count);
      }
    });
  });
  for (int i = 0; i < misses; ++i) wave.finished.push(wave.miss[i]);
  wave.miss.clear();
  wave.emitter.clear();
}

SHEAF_INSTANTIATE_STAGE(emission);

}  // namespace sheaf
