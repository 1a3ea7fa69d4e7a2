// Projector lights; see ProjectorDescription.
#pragma once

#include "kernels/lights/spot_light.h"
#include "scene/lights/projector_light.h"

namespace sheaf {

struct ProjectorLight {
  using Kind = ProjectorLightKind;
  static constexpr LightHitKind kHitKind = LightHitKind::kNever;

  template <class L, ColorMode kMode>
  static SHEAF_INLINE LightSample<L> sample(const LightQuery<L>& lights, Vec3<L> from, const Random4<L>&,
                                            TextureQuery<L>& texture) {
    using F = Float<L>;
    using U = Uint<L>;
    const ProjectorLightData<L> light = lights.light.template data<ProjectorLightData>();
    const LightFrameRecord<L> frame = load_frames<L>(lights, light.frame);
    const Vec2<L> scale = light.image_scale;
    const Vec3<L> local = frame.local_point(from);
    const auto ahead = local.z > F(0.0f);
    const F depth = select(ahead, local.z, F(1.0f));
    const F u = F(0.5f) - local.x / depth * scale.x, v = F(0.5f) - local.y / depth * scale.y;
    LightSample<L> s = sample_position<L>(lights.light, light.position, from);
    s.valid = s.valid & ahead & (min(u, v) >= F(0.0f)) & (max(u, v) <= F(1.0f));
    const F inverse_cosine = sqrt(dot(local, local)) / depth;
    const F inverse_cosines = inverse_cosine * inverse_cosine * inverse_cosine;
    s.radiance = s.radiance * select(lights.light.has_flag(kConstantIntensity), F(1.0f), inverse_cosines);
    set_query<L>(lights.active & s.valid, {{u, v}, U(0u), U(0u), F(0.0f), F(0.0f)}, texture);
    return s;
  }

  /// Uniform over the image. Unless the light is even, its intensity is proportional to 1 / cos^3, as is the pdf of the
  /// directions.
  template <class L, ColorMode kMode>
  static SHEAF_INLINE PhotonEmission<L> emit(const LightQuery<L>& lights, const Random4<L>&, const Random4<L>& b,
                                             TextureQuery<L>& texture) {
    using F = Float<L>;
    const ProjectorLightData<L> light = lights.light.template data<ProjectorLightData>();
    const LightFrameRecord<L> frame = load_frames<L>(lights, light.frame);
    const Vec2<L> scale = light.image_scale;
    const Vec3<L> local{(F(0.5f) - b.x) / scale.x, (F(0.5f) - b.y) / scale.y, F(1.0f)};
    const F distance = length(local), inverse_area = scale.x * scale.y;
    const F inverse_cosines = distance * distance * distance;
    auto e = emit_from_position<L>(lights.light, light.position, normalize_any(frame.world_vector(local)),
                                   inverse_area * inverse_cosines);
    e.flux = lights.light.radiance *
             (F(1.0f) / (inverse_area * select(lights.light.has_flag(kConstantIntensity), inverse_cosines, F(1.0f))));
    set_query<L>(lights.active, {{b.x, b.y}, Uint<L>(0u), Uint<L>(0u), F(0.0f), F(0.0f)}, texture);
    return e;
  }
};

template <> struct LightOf<ProjectorLightKind> { using Type = ProjectorLight; };

}  // namespace sheaf
