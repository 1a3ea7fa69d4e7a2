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

/// The vertex that the ray comes from, as light_candidates saw it.
template <class L>
SHEAF_INLINE LightReceiver<L> receiver(const RayState<L>& ray, const RadianceState<L>& radiance) {
  return {ray.origin, decode_octahedral<L>(radiance.normal)};
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
    const EnvmapValue<L> found = lookup_envmap<L>(scene.envmap, direction);
    return {uplifted_light<L>(scene, found.radiance, lambda) * emitted, found.pdf_solid_angle};
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
    const F probability = choice_probability<L>(scene, receiver<L>(ray, radiance), U(scene.environment));
    const F weight =
        emission_weight<L>(scene.integrator, radiance.scatter_pdf, probability * arriving.pdf_solid_angle);
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
  const F pdf = choice_probability<L>(scene, receiver<L>(ray, radiance), hit.light) *
                light_pdf_solid_angle<L>(scene, light, Mask<L>(true), ray.origin, ray.direction, hit.t, y.ng);
  const F weight = emission_weight<L>(scene.integrator, radiance.scatter_pdf, pdf);
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
