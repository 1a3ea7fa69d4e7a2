// A disk of constant radiance at infinity, sampled uniformly in its cone of directions.
#pragma once

#include "kernels/lights/infinite_light.h"

namespace sheaf {

struct SunLight {
  static constexpr LightKind kKind = LightKind::kSun;
  static constexpr LightHitKind kHitKind = LightHitKind::kEscape;

  template <class L, ColorMode Mode>
  static SHEAF_INLINE LightSample<L> sample(const LightQuery<L>& lights, Vec3<L> from, const Random4<L>& u,
                                            TextureQuery<L>&) {
    LightSample<L> s;
    s.direction = direction_of<L>(lights.light, u.y, u.z);
    s.target = beyond_scene<L>(lights.scene, from, s.direction);
    s.radiance = lights.light.radiance;
    s.pdf_solid_angle = pdf<L>(lights.light.radius);
    s.valid = Mask<L>(true);
    return s;
  }

  /// 1 - cos of the angle between unit vectors is half their squared distance; accurate for small angles.
  template <class L, ColorMode Mode>
  static SHEAF_INLINE EnvmapValue<L> arriving(const SceneView&, const LightRow& light, const Spectrum<L>& emitted,
                                              Vec3<L> direction, const Spectrum<L>&) {
    using F = Float<L>;
    const auto seen = length_squared(direction - broadcast<L>(light.position)) <= F(2.0f * light.radius);
    return {select<L>(seen, emitted, Spectrum<L>(F(0.0f))), select(seen, pdf<L>(F(light.radius)), F(0.0f))};
  }

  template <class L, ColorMode Mode>
  static SHEAF_INLINE PhotonEmission<L> emit(const LightQuery<L>& lights, const Random4<L>& a, const Random4<L>& b,
                                             TextureQuery<L>&) {
    const LightRecord<L>& light = lights.light;
    return emit_from_infinity<L>(lights.scene, -direction_of<L>(light, b.x, b.y), light.radiance, pdf<L>(light.radius),
                                 a);
  }

 private:
  template <class L> static SHEAF_INLINE Vec3<L> direction_of(const LightRecord<L>& light, Float<L> u, Float<L> v) {
    return Frame<L>::from_normal(light.position).to_world(square_to_cone<L>(u, v, light.radius));
  }

  template <class L> static SHEAF_INLINE Float<L> pdf(Float<L> one_minus_cos) {
    return Float<L>(0.5f * kInvPi) / max(one_minus_cos, Float<L>(1e-37f));
  }
};

}  // namespace sheaf
