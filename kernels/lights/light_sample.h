// Light sampling: samples a point on a light, and returns the radiance that it sends to a reference point and the pdf.
// Also returns that pdf for a point found by BSDF sampling.
#pragma once

#include "core/color/uplift.h"
#include "core/sampling/sampler.h"
#include "core/soa/lane_array.h"
#include "kernels/lights/light_coat.h"
#include "kernels/lights/light_select.h"
#include "kernels/lights/list.h"
#include "kernels/lights/moving_light.h"

namespace sheaf {

/// Spectral mode: emission of the lights' rows at the wavelengths `lambda`.
template <class L>
SHEAF_INLINE Spectrum<L> light_spectra(const SceneView& scene, typename L::Uint light, const Spectrum<L>& lambda) {
  return evaluate<L>(scene.spectral.lights, light, scene.spectral.tables, lambda);
}

/// Spectra of texture colors, as factors on light_spectra().
template <class L>
SHEAF_INLINE Spectrum<L> uplifted_light(const SceneView& scene, const Spectrum<L>& rgb, const Spectrum<L>& lambda) {
  return evaluate(uplift_unbounded<L>(*scene.spectral.uplift, {rgb.c0, rgb.c1, rgb.c2}), lambda);
}

/// Values of the lights' textures, clamped to at least 0; 1 for lights without texture. Lanes of a register may have
/// different textures. `lambda`: spectral mode.
template <class L, ColorMode kMode = ColorMode::kRgb>
Spectrum<L> light_textures(const SceneView& scene, Uint<L> texture, Mask<L> active, const TextureQuery<L>& query,
                           const Spectrum<L>& lambda = {}) {
  using F = Float<L>;
  using U = Uint<L>;
  Spectrum<L> out(F(1.0f));
  const LaneArray<U> lanes(texture);
  for (std::uint32_t left = mask_bits(active & (texture != U(kNone))); left != 0;) {
    const std::uint32_t row = lanes[std::countr_zero(left)];
    const auto same = texture == U(row);
    Spectrum<L> value = lookup_texture<L>(scene.textures, row, query);
    if constexpr (kMode == ColorMode::kSpectral) value = uplifted_light<L>(scene, value, lambda);
    const F zero(0.0f);
    out = select<L>(same, {max(value.c0, zero), max(value.c1, zero), max(value.c2, zero), max(value.c3, zero)}, out);
    left &= ~mask_bits(same);
  }
  return out;
}

/// 1 + the row of the medium that a volume light fills, as in ray flags; kNone for other lights.
template <class L> SHEAF_INLINE Uint<L> light_medium(const LightRecord<L>& light) {
  Uint<L> medium(kNone);
  Lights::for_each([&]<class Light>(Light) SHEAF_LAMBDA_INLINE {
    if constexpr (Light::kHitKind == LightHitKind::kMedium)
      medium =
          select(light.is(kLightKind<typename Light::Kind>), Light::template medium<L>(light) + Uint<L>(1u), medium);
  });
  return medium;
}

namespace light_detail {

/// Samples lights of type `Light` in the lanes of `lights.active`.
template <class L, ColorMode kMode, class Light>
SHEAF_INLINE LightSample<L> sample_kind(const LightQuery<L>& lights, Vec3<L> from, const Random4<L>& u,
                                        TextureQuery<L>& texture) {
  LightSample<L> s = Light::template sample<L, kMode>(lights, from, u, texture);
  s.delta = Mask<L>(Light::kHitKind == LightHitKind::kNever);
  return s;
}

template <class L> SHEAF_INLINE void merge(Mask<L> m, const LightSample<L>& a, LightSample<L>& into) {
  into.direction = select<L>(m, a.direction, into.direction);
  into.target = select<L>(m, a.target, into.target);
  into.radiance = select<L>(m, a.radiance, into.radiance);
  into.pdf_solid_angle = select(m, a.pdf_solid_angle, into.pdf_solid_angle);
  into.delta = select(m, a.delta, into.delta);
  into.valid = select(m, a.valid, into.valid);
  into.normal = select<L>(m, a.normal, into.normal);
}

/// sample_given_light() unless all lights are of one kind that is sampled inline. Not inlined, because the code of all
/// kinds is large.
template <class L, ColorMode kMode>
[[gnu::noinline]] LightSample<L> sample_mixed_lights(LightQuery<L> lights, Vec3<L> from, const Random4<L>& u,
                                                     TextureQuery<L>& texture) {
  LightSample<L> s{};
  Lights::for_each([&]<class Light>(Light) SHEAF_LAMBDA_INLINE {
    lights.active = lights.light.is(kLightKind<typename Light::Kind>);
    if (any(lights.active)) merge<L>(lights.active, sample_kind<L, kMode, Light>(lights, from, u, texture), s);
  });
  return s;
}

/// Samples given lights in their rest pose, without their coats. `query`: set where a texture is looked up.
template <class L, ColorMode kMode>
SHEAF_INLINE LightSample<L> sample_at_rest(const SceneView& scene, const LightSampleContext<L>& at,
                                           const LightRecord<L>& light, const Random4<L>& u, const Spectrum<L>& lambda,
                                           const EnvmapDraw<L>* drawn, Float<L> time, TextureQuery<L>& query) {
  const LightQuery<L> lights{scene, light, Mask<L>(true), lambda, drawn, time, at.n};
  LightSample<L> s;
  const bool is_done = Lights::any_of([&]<class Light>(Light) SHEAF_LAMBDA_INLINE {
    if constexpr (kIsSampledInline<Light>)
      if (all(light.is(kLightKind<typename Light::Kind>))) {
        s = sample_kind<L, kMode, Light>(lights, at.p, u, query);
        return true;
      }
    return false;
  });
  if (!is_done) s = sample_mixed_lights<L, kMode>(lights, at.p, u, query);
  s.target_medium = light_medium<L>(light);
  const auto textured = s.valid & (light.texture != Uint<L>(kNone));
  if (any(textured)) s.radiance = s.radiance * light_textures<L, kMode>(scene, light.texture, textured, query, lambda);
  return s;
}

/// Attenuates the light of area lights by their coats. The sample's direction and normal must be those in the world.
template <class L>
SHEAF_INLINE void apply_coats(const SceneView& scene, const LightRecord<L>& light, const TextureQuery<L>& query,
                              LightSample<L>& s) {
  if (scene.lights.coats == nullptr) return;
  const Float<L> cosine = dot(s.direction, s.normal) / max(length(s.normal), Float<L>(1e-20f));
  s.radiance = s.radiance * coat_transmittance<L>(scene, light, s.valid, cosine, query);
}

}  // namespace light_detail

/// Samples a direction from `at` towards given lights by u.y, u.z and u.w. The pdf does not include the choice of the
/// light. In spectral mode light.radiance must be light_spectra() at `lambda`. `drawn`: see LightQuery.
template <class L, ColorMode kMode = ColorMode::kRgb>
SHEAF_INLINE LightSample<L> sample_given_light(const SceneView& scene, const LightSampleContext<L>& at,
                                               const LightRecord<L>& light, const Random4<L>& u,
                                               const Spectrum<L>& lambda = {}, const EnvmapDraw<L>* drawn = nullptr,
                                               Float<L> time = Float<L>(0.0f)) {
  TextureQuery<L> query{};
  LightSample<L> s = light_detail::sample_at_rest<L, kMode>(scene, at, light, u, lambda, drawn, time, query);
  light_detail::apply_coats<L>(scene, light, query, s);
  return s;
}

/// Samples a direction from `at` towards the chosen lights at times in [0, 1]. The pdf includes the choice. `lambda`:
/// wavelengths in spectral mode. `drawn`: see LightQuery.
template <class L, ColorMode kMode = ColorMode::kRgb>
SHEAF_INLINE LightSample<L> sample_light(const SceneView& scene, const LightSampleContext<L>& at,
                                         const LightChoice<L>& choice, const Random4<L>& u, Float<L> time,
                                         const Spectrum<L>& lambda = {}, const EnvmapDraw<L>* drawn = nullptr) {
  LightRecord<L> light = load_lights<L>(scene, choice.light);
  if constexpr (kMode == ColorMode::kSpectral) light.radiance = light_spectra<L>(scene, choice.light, lambda);
  LightSample<L> s;
  if (scene.motion.lights == nullptr) {
    s = sample_given_light<L, kMode>(scene, at, light, u, lambda, drawn, time);
  } else {
    const MotionSample<L> motion = light_motion<L>(scene, choice.light, Mask<L>(true), time);
    TextureQuery<L> query{};
    s = light_detail::sample_at_rest<L, kMode>(scene, {rest_point<L>(motion, at.p), {}}, light, u, lambda, drawn, time,
                                               query);
    move_light_sample<L>(scene, motion, choice.light, s);
    light_detail::apply_coats<L>(scene, light, query, s);
  }
  s.delta = s.delta | light.has_flag(kMissedByRays);
  s.pdf_solid_angle = s.pdf_solid_angle * choice.probability;
  return s;
}

/// Pdf, without the choice of the light, with which sample_light() samples a point of the area light `row` at times in
/// [0, 1]. `light` is its record.
template <class L>
SHEAF_INLINE Float<L> light_pdf_solid_angle(const SceneView& scene, Uint<L> row, const LightRecord<L>& light,
                                            Mask<L> active, LightHit<L> hit, Float<L> time) {
  Float<L> factor(1.0f);
  if (scene.motion.lights != nullptr) {
    factor = rest_hit<L>(light_motion<L>(scene, row, active, time), hit);
    hit.normal = {};  // as in sample_light()
  }
  const Spectrum<L> no_lambda;
  Float<L> pdf(0.0f);
  Lights::for_each([&]<class Light>(Light) SHEAF_LAMBDA_INLINE {
    if constexpr (Light::kHitKind == LightHitKind::kSurface) {
      const Mask<L> here = active & light.is(kLightKind<typename Light::Kind>);
      if (any(here))
        pdf = select(
            here, Light::template pdf_solid_angle<L>({scene, light, here, no_lambda, nullptr, time, hit.normal}, hit),
            pdf);
    }
  });
  return pdf * factor;
}

/// Whether light `index` is hit by paths that leave the scene.
inline bool surrounds_scene(const SceneView& scene, std::uint32_t index) {
  bool surrounds = false;
  Lights::for_each([&]<class Light>(Light) {
    if constexpr (Light::kHitKind == LightHitKind::kEscape)
      surrounds = surrounds || scene.lights.rows[index].is(kLightKind<typename Light::Kind>);
  });
  return surrounds;
}

/// Radiance from `direction` at times in [0, 1] of light `index`, which must surround the scene. Includes the pdf with
/// which sample_light() samples that direction, without the choice of the light. `lambda`: spectral mode.
template <class L, ColorMode kMode>
SHEAF_INLINE EnvmapValue<L> environment_value(const SceneView& scene, std::uint32_t index, Vec3<L> direction,
                                              Float<L> time, const Spectrum<L>& lambda) {
  using F = Float<L>;
  const LightRow& light = scene.lights.rows[index];
  const Spectrum4& rgb = light.radiance;
  Spectrum<L> emitted{F(rgb.c0), F(rgb.c1), F(rgb.c2), F(rgb.c3)};
  if constexpr (kMode == ColorMode::kSpectral) emitted = light_spectra<L>(scene, Uint<L>(index), lambda);
  F factor(1.0f);
  if (scene.motion.lights != nullptr) {
    LightHit<L> hit{{}, direction, F(0.0f), direction};
    factor = rest_hit<L>(light_motion<L>(scene, Uint<L>(index), Mask<L>(true), time), hit);
    direction = hit.direction;
  }
  EnvmapValue<L> value{};
  Lights::for_each([&]<class Light>(Light) SHEAF_LAMBDA_INLINE {
    if constexpr (Light::kHitKind == LightHitKind::kEscape)
      if (light.is(kLightKind<typename Light::Kind>))
        value = Light::template arriving<L, kMode>(scene, light, emitted, direction, lambda);
  });
  value.pdf_solid_angle = value.pdf_solid_angle * factor;
  return value;
}

}  // namespace sheaf
