// Point lights whose intensity is multiplied by an image of all directions; see GoniometricLightDescription.
#pragma once

#include "core/sampling/octahedral.h"
#include "kernels/lights/spot_light.h"
#include "scene/lights/goniometric_light.h"

namespace sheaf {

struct GoniometricLight {
  using Kind = GoniometricLightKind;
  static constexpr LightHitKind kHitKind = LightHitKind::kNever;

  template <class L, ColorMode kMode>
  static SHEAF_INLINE LightSample<L> sample(const LightQuery<L>& lights, Vec3<L> from, const Random4<L>&,
                                            TextureQuery<L>& texture) {
    const FramedLightData<L> light = lights.light.template data<FramedLightData>();
    const LightFrameRecord<L> frame = load_frames<L>(lights, light.frame);
    LightSample<L> s = sample_position<L>(lights.light, light.position, from);
    look_up<L>(lights.active & s.valid, normalize_any(frame.local_point(from)), texture);
    return s;
  }

  /// Uniform directions, weighted by the image.
  template <class L, ColorMode kMode>
  static SHEAF_INLINE PhotonEmission<L> emit(const LightQuery<L>& lights, const Random4<L>&, const Random4<L>& b,
                                             TextureQuery<L>& texture) {
    const FramedLightData<L> light = lights.light.template data<FramedLightData>();
    const LightFrameRecord<L> frame = load_frames<L>(lights, light.frame);
    const Vec3<L> local = square_to_sphere<L>(b.x, b.y);
    look_up<L>(lights.active, local, texture);
    return emit_from_position<L>(lights.light, light.position, normalize_any(frame.world_vector(local)),
                                 Float<L>(kUniformSpherePdf));
  }

 private:
  /// The last row of the image is at v = 0; the first is where y of the octahedral map is smallest.
  template <class L> static SHEAF_INLINE void look_up(Mask<L> m, Vec3<L> local, TextureQuery<L>& texture) {
    using F = Float<L>;
    using U = Uint<L>;
    const Vec2<L> uv = equal_area_octahedral<L>(local);
    set_query<L>(m, {{uv.x, F(1.0f) - uv.y}, U(0u), U(0u), F(0.0f), F(0.0f)}, texture);
  }
};

template <> struct LightOf<GoniometricLightKind> { using Type = GoniometricLight; };

}  // namespace sheaf
