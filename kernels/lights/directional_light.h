// A directional light: parallel light from infinitely far away.
#pragma once

#include "kernels/lights/infinite_light.h"
#include "scene/lights/directional_light.h"

namespace sheaf {

struct DirectionalLight {
  using Kind = DirectionalLightKind;
  static constexpr LightHitKind kHitKind = LightHitKind::kNever;

  template <class L, ColorMode kMode>
  static SHEAF_INLINE LightSample<L> sample(const LightQuery<L>& lights, Vec3<L> from, const Random4<L>&,
                                            TextureQuery<L>&) {
    LightSample<L> s;
    s.direction = lights.light.template data<DirectionalLightData>().to_light;
    s.target = beyond_scene<L>(lights.scene, from, s.direction);
    s.radiance = lights.light.radiance;
    s.pdf_solid_angle = Float<L>(1.0f);
    s.valid = Mask<L>(true);
    return s;
  }

  template <class L, ColorMode kMode>
  static SHEAF_INLINE PhotonEmission<L> emit(const LightQuery<L>& lights, const Random4<L>& a, const Random4<L>&,
                                             TextureQuery<L>&) {
    const Vec3<L> to_light = lights.light.template data<DirectionalLightData>().to_light;
    return emit_from_infinity<L>(lights.scene, -to_light, lights.light.radiance, Float<L>(1.0f), a);
  }
};

template <> struct LightOf<DirectionalLightKind> { using Type = DirectionalLight; };

}  // namespace sheaf
