// A disk of constant radiance at infinity, sampled uniformly in its cone of directions.
#pragma once

#include "kernels/lights/infinite_light.h"
#include "scene/lights/sun_light.h"

namespace sheaf {

struct SunLight {
  using Kind = SunLightKind;
  static constexpr LightHitKind kHitKind = LightHitKind::kEscape;

  template <class L, ColorMode kMode>
  static SHEAF_INLINE LightSample<L> sample(const LightQuery<L>& lights, Vec3<L> from, const Random4<L>& u,
                                            TextureQuery<L>&) {
    const SunLightData<L> sun = lights.light.template data<SunLightData>();
    LightSample<L> s;
    s.direction = direction_of<L>(sun, u.y, u.z);
    s.target = beyond_scene<L>(lights.scene, from, s.direction);
    s.radiance = lights.light.radiance;
    s.pdf_solid_angle = pdf<L>(sun.one_minus_cos);
    s.valid = Mask<L>(true);
    return s;
  }

  /// 1 - cos of the angle between unit vectors is half their squared distance; accurate for small angles.
  template <class L, ColorMode kMode>
  static SHEAF_INLINE EnvmapValue<L> arriving(const SceneView&, const LightRow& light, const Spectrum<L>& emitted,
                                              Vec3<L> direction, const Spectrum<L>&) {
    using F = Float<L>;
    const SunLightData<Scalar> sun = light.data<SunLightData>();
    const auto seen = length_squared(direction - broadcast<L>(sun.to_light)) <= F(2.0f * sun.one_minus_cos);
    return {select<L>(seen, emitted, Spectrum<L>(F(0.0f))), select(seen, pdf<L>(F(sun.one_minus_cos)), F(0.0f))};
  }

  template <class L, ColorMode kMode>
  static SHEAF_INLINE PhotonEmission<L> emit(const LightQuery<L>& lights, const Random4<L>& a, const Random4<L>& b,
                                             TextureQuery<L>&) {
    const SunLightData<L> sun = lights.light.template data<SunLightData>();
    return emit_from_infinity<L>(lights.scene, -direction_of<L>(sun, b.x, b.y), lights.light.radiance,
                                 pdf<L>(sun.one_minus_cos), a);
  }

 private:
  template <class L> static SHEAF_INLINE Vec3<L> direction_of(const SunLightData<L>& sun, Float<L> u, Float<L> v) {
    return Frame<L>::from_normal(sun.to_light).to_world(square_to_cone<L>(u, v, sun.one_minus_cos));
  }

  template <class L> static SHEAF_INLINE Float<L> pdf(Float<L> one_minus_cos) {
    return Float<L>(0.5f * kInvPi) / max(one_minus_cos, Float<L>(1e-37f));
  }
};

template <> struct LightOf<SunLightKind> { using Type = SunLight; };

}  // namespace sheaf
