// A light that emits along a single ray; only photons can transport it.
#pragma once

#include "kernels/lights/point_light.h"
#include "scene/lights/beam_light.h"

namespace sheaf {

struct BeamLight {
  using Kind = BeamLightKind;
  static constexpr LightHitKind kHitKind = LightHitKind::kNever;
  static constexpr bool kIsForPhotons = true;

  /// Never valid: only points on the ray receive light.
  template <class L, ColorMode kMode>
  static SHEAF_INLINE LightSample<L> sample(const LightQuery<L>& lights, Vec3<L> from, const Random4<L>&,
                                            TextureQuery<L>&) {
    LightSample<L> s = sample_position<L>(lights.light, lights.light.template data<BeamLightData>().position, from);
    s.valid = Mask<L>(false);
    return s;
  }

  template <class L, ColorMode kMode>
  static SHEAF_INLINE PhotonEmission<L> emit(const LightQuery<L>& lights, const Random4<L>&, const Random4<L>&,
                                             TextureQuery<L>&) {
    const BeamLightData<L> beam = lights.light.template data<BeamLightData>();
    return emit_from_position<L>(lights.light, beam.position, beam.direction, Float<L>(1.0f));
  }
};

template <> struct LightOf<BeamLightKind> { using Type = BeamLight; };

}  // namespace sheaf
