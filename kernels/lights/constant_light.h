// An infinite area light of constant radiance.
#pragma once

#include "kernels/lights/infinite_light.h"
#include "scene/lights/constant_light.h"

namespace sheaf {

struct ConstantLight {
  using Kind = ConstantLightKind;
  static constexpr LightHitKind kHitKind = LightHitKind::kEscape;

  template <class L, ColorMode kMode>
  static SHEAF_INLINE LightSample<L> sample(const LightQuery<L>& lights, Vec3<L> from, const Random4<L>& u,
                                            TextureQuery<L>&) {
    LightSample<L> s;
    s.direction = square_to_sphere<L>(u.y, u.z);
    s.target = beyond_scene<L>(lights.scene, from, s.direction);
    s.radiance = lights.light.radiance;
    s.pdf_solid_angle = Float<L>(kUniformSpherePdf);
    s.valid = Mask<L>(true);
    return s;
  }

  template <class L, ColorMode kMode>
  static SHEAF_INLINE EnvmapValue<L> arriving(const SceneView&, const LightRow&, const Spectrum<L>& emitted, Vec3<L>,
                                              const Spectrum<L>&) {
    return {emitted, Float<L>(kUniformSpherePdf)};
  }

  template <class L, ColorMode kMode>
  static SHEAF_INLINE PhotonEmission<L> emit(const LightQuery<L>& lights, const Random4<L>& a, const Random4<L>& b,
                                             TextureQuery<L>&) {
    return emit_from_infinity<L>(lights.scene, square_to_sphere<L>(b.x, b.y), lights.light.radiance,
                                 Float<L>(kUniformSpherePdf), a);
  }
};

template <> struct LightOf<ConstantLightKind> { using Type = ConstantLight; };

}  // namespace sheaf
