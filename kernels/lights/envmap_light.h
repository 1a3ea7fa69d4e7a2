// Environment map lights, sampled in proportion to the map's brightness.
#pragma once

#include "kernels/lights/infinite_light.h"
#include "scene/lights/envmap_light.h"

namespace sheaf {

struct EnvmapLight {
  using Kind = EnvmapLightKind;
  static constexpr LightHitKind kHitKind = LightHitKind::kEscape;

  template <class L, ColorMode kMode>
  static SHEAF_INLINE LightSample<L> sample(const LightQuery<L>& lights, Vec3<L> from, const Random4<L>& u,
                                            TextureQuery<L>&) {
    const EnvmapView& map = lights.scene.lights.envmap;
    const auto found = lights.drawn != nullptr ? sample_envmap<L, kMode>(map, *lights.drawn, lights.lambda)
                                               : sample_envmap<L, kMode>(map, u.y, u.z, lights.lambda);
    LightSample<L> s;
    s.direction = found.direction;
    s.target = beyond_scene<L>(lights.scene, from, s.direction);
    s.radiance = lit<L, kMode>(found.radiance, lights.light.radiance);
    s.pdf_solid_angle = found.pdf_solid_angle;
    s.valid = found.pdf_solid_angle > Float<L>(0.0f);
    return s;
  }

  template <class L, ColorMode kMode>
  static SHEAF_INLINE EnvmapValue<L> arriving(const SceneView& scene, const LightRow&, const Spectrum<L>& emitted,
                                              Vec3<L> direction, const Spectrum<L>& lambda) {
    const auto found = lookup_envmap<L, kMode>(scene.lights.envmap, direction, lambda);
    return {lit<L, kMode>(found.radiance, emitted), found.pdf_solid_angle};
  }

  /// Samples directions from the map, and a fraction of the photons uniformly (balance heuristic).
  template <class L, ColorMode kMode>
  static SHEAF_INLINE PhotonEmission<L> emit(const LightQuery<L>& lights, const Random4<L>& a, const Random4<L>& b,
                                             TextureQuery<L>&) {
    using F = Float<L>;
    const EnvmapView& map = lights.scene.lights.envmap;
    const Vec3<L> to_light = select<L>(b.z < F(kUniformProbability), square_to_sphere<L>(b.x, b.y),
                                       sample_envmap<L, kMode>(map, b.x, b.y, lights.lambda).direction);
    const auto value = arriving<L, kMode>(lights.scene, {}, lights.light.radiance, to_light, lights.lambda);
    const F pdf = fma(F(1.0f - kUniformProbability), value.pdf_solid_angle, F(kUniformProbability * kUniformSpherePdf));
    return emit_from_infinity<L>(lights.scene, -to_light, value.radiance, pdf, a);
  }

 private:
  /// Fraction of the photons with uniform directions. The map's own pdf is 0 where EnvmapDescription::mis_compensation
  /// reduces it to 0.
  static constexpr float kUniformProbability = 0.125f;

  /// Spectral mode: the map multiplies the emission of the light's row.
  template <class L, ColorMode kMode>
  static SHEAF_INLINE Spectrum<L> lit(const Spectrum<L>& found, const Spectrum<L>& emitted) {
    if constexpr (kMode == ColorMode::kSpectral) return found * emitted;
    return found;
  }
};

template <> struct LightOf<EnvmapLightKind> { using Type = EnvmapLight; };

}  // namespace sheaf
