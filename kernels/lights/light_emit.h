// Photon emission by lights of any kind: position, direction and flux. For the photon pass; camera paths sample lights
// by kernels/lights/light_sample.h instead.
#pragma once

#include "kernels/lights/light_sample.h"

namespace sheaf {

namespace light_emit_detail {

template <class L> SHEAF_INLINE void merge(Mask<L> m, const PhotonEmission<L>& from, PhotonEmission<L>& into) {
  into.origin = select<L>(m, from.origin, into.origin);
  into.direction = select<L>(m, from.direction, into.direction);
  into.flux = select<L>(m, from.flux, into.flux);
  into.pdf_position = select(m, from.pdf_position, into.pdf_position);
  into.pdf_direction = select(m, from.pdf_direction, into.pdf_direction);
  into.valid = select(m, from.valid, into.valid);
  into.normal = select<L>(m, from.normal, into.normal);
}

}  // namespace light_emit_detail

/// Emits a photon from each light chosen by choose_light_by_power(). a.y, a.z and a.w choose the position, b.x, b.y and
/// b.z the direction. `time`: in [0, 1]. Spectral mode: flux at `lambda`, per nanometer.
template <class L, ColorMode kMode = ColorMode::kRgb>
PhotonEmission<L> emit_photon(const SceneView& scene, const LightChoice<L>& choice, const Random4<L>& a,
                              const Random4<L>& b, Float<L> time, const Spectrum<L>& lambda = {}) {
  using F = Float<L>;
  LightRecord<L> light = load_lights<L>(scene, choice.light);
  if constexpr (kMode == ColorMode::kSpectral) light.radiance = light_spectra<L>(scene, choice.light, lambda);
  PhotonEmission<L> e{};
  TextureQuery<L> query{};
  Lights::for_each([&]<class Light>(Light) SHEAF_LAMBDA_INLINE {
    const auto active = light.is(kLightKind<typename Light::Kind>);
    if (!any(active)) return;
    light_emit_detail::merge<L>(
        active, Light::template emit<L, kMode>({scene, light, active, lambda, nullptr, time}, a, b, query), e);
  });
  e.medium = light_medium<L>(light);
  const auto textured = e.valid & (light.texture != Uint<L>(kNone));
  if (any(textured)) e.flux = e.flux * light_textures<L, kMode>(scene, light.texture, textured, query, lambda);
  if (scene.motion.lights != nullptr) {
    auto on_shape = Mask<L>(false);
    Lights::for_each([&]<class Light>(Light) SHEAF_LAMBDA_INLINE {
      if constexpr (Light::kHitKind == LightHitKind::kSurface)
        on_shape = on_shape | light.is(kLightKind<typename Light::Kind>);
    });
    move_photon<L>(light_motion<L>(scene, choice.light, Mask<L>(true), time), e, on_shape);
  }
  if (scene.lights.coats != nullptr) {
    const F cosine = dot(e.direction, e.normal) / max(length(e.normal), F(1e-20f));
    e.flux = e.flux * coat_transmittance<L>(scene, light, e.valid, cosine, query);
  }
  const auto chosen = choice.probability > F(0.0f);
  e.flux = e.flux * (F(1.0f) / select(chosen, choice.probability, F(1.0f)));
  e.valid = e.valid & chosen & is_finite(e.direction) & is_finite(max_component(e.flux));
  return e;
}

}  // namespace sheaf
