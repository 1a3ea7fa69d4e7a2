// Spot lights with linear or smooth falloff; see SpotLightDescription.
#pragma once

#include "kernels/lights/point_light.h"
#include "scene/lights/spot_light.h"
#include "scene/surfaces/shape.h"

namespace sheaf {

/// Loads the rows light_frames[frame] of the active lanes.
template <class L> SHEAF_INLINE LightFrameRecord<L> load_frames(const LightQuery<L>& lights, typename L::Uint frame) {
  return gather_rows<L>(lights.scene.lights.frames, select(lights.active, frame, Uint<L>(0u)));
}

/// `SpotKind`: LinearSpotLightKind or SmoothSpotLightKind.
template <class SpotKind> struct SpotLight {
  using Kind = SpotKind;
  static constexpr LightHitKind kHitKind = LightHitKind::kNever;

  template <class L, ColorMode kMode>
  static SHEAF_INLINE LightSample<L> sample(const LightQuery<L>& lights, Vec3<L> from, const Random4<L>&,
                                            TextureQuery<L>& texture) {
    const SpotLightData<L> spot = lights.light.template data<SpotLightData>();
    const LightFrameRecord<L> frame = load_frames<L>(lights, spot.frame);
    const Float<L> attenuation = falloff<L>(lights, spot, frame.local_point(from), texture);
    LightSample<L> s = sample_position<L>(lights.light, spot.position, from);
    s.radiance = s.radiance * attenuation;
    s.valid = s.valid & (attenuation > Float<L>(0.0f));
    return s;
  }

  /// Uniform directions in the cone, weighted by the falloff.
  template <class L, ColorMode kMode>
  static SHEAF_INLINE PhotonEmission<L> emit(const LightQuery<L>& lights, const Random4<L>&, const Random4<L>& b,
                                             TextureQuery<L>& texture) {
    using F = Float<L>;
    const SpotLightData<L> spot = lights.light.template data<SpotLightData>();
    const LightFrameRecord<L> frame = load_frames<L>(lights, spot.frame);
    const F one_minus_cos = cone_one_minus_cos<L>(spot);
    const Vec3<L> local = square_to_cone<L>(b.x, b.y, one_minus_cos);
    const Vec3<L> along = frame.world_vector(local);
    const F attenuation = falloff<L>(lights, spot, local, texture);
    const F pdf = world_pdf<L>(frame, along, F(0.5f * kInvPi) / max(one_minus_cos, F(1e-37f)));
    auto e = emit_from_position<L>(lights.light, spot.position, normalize_any(along), pdf);
    e.flux = e.flux * attenuation;
    e.valid = e.valid & (attenuation > F(0.0f));
    return e;
  }

 private:
  /// Falloff in [0, 1], without texture, in the direction `local`, a vector in the light's space.
  template <class L>
  static SHEAF_INLINE Float<L> falloff(const LightQuery<L>& lights, const SpotLightData<L>& spot, Vec3<L> local,
                                       TextureQuery<L>& texture) {
    using F = Float<L>;
    using U = Uint<L>;
    F x;
    if constexpr (!Kind::kIsSmooth) {
      // Compute the angle from its tangent, which is accurate near the axis.
      x = spot.cutoff - atan2(sqrt(local.x * local.x + local.y * local.y), local.z);
    } else {
      x = local.z / max(sqrt(dot(local, local)), F(1e-37f)) - spot.cutoff;
    }
    const F step = clamp(x * spot.inverse_width, F(0.0f), F(1.0f));
    const auto textured = lights.active & (step > F(0.0f)) & (lights.light.texture != U(kNone));
    if (any(textured)) {
      const F scale = F(0.5f) * spot.cot_cutoff / max(local.z, F(1e-37f));
      const Vec2<L> uv{F(0.5f) + local.x * scale, F(0.5f) + local.y * scale};
      set_query<L>(textured, {uv, U(0u), U(0u), F(0.0f), F(0.0f)}, texture);
    }
    return Kind::kIsSmooth ? step * step * (F(3.0f) - F(2.0f) * step) : step;
  }

  template <class L> static SHEAF_INLINE Float<L> cone_one_minus_cos(const SpotLightData<L>& spot) {
    using F = Float<L>;
    if constexpr (!Kind::kIsSmooth) {
      // 1 - cos of the cutoff angle c is 2 sin^2(c / 2).
      const F half = sincos_2pi<L>(clamp(spot.cutoff * F(0.25f * kInvPi), F(0.0f), F(0.25f))).sin;
      return F(2.0f) * half * half;
    } else {
      return F(1.0f) - spot.cutoff;
    }
  }

  /// Converts `pdf`, per solid angle in the light's space, to world space. `along` is the world_vector() of a unit
  /// vector: a linear map of determinant D scales solid angles by |D| / |along|^3.
  template <class L>
  static SHEAF_INLINE Float<L> world_pdf(const LightFrameRecord<L>& frame, Vec3<L> along, Float<L> pdf) {
    const Float<L> l = length(along);
    return pdf * abs(frame.determinant()) * l * l * l;
  }
};

template <> struct LightOf<LinearSpotLightKind> { using Type = SpotLight<LinearSpotLightKind>; };
template <> struct LightOf<SmoothSpotLightKind> { using Type = SpotLight<SmoothSpotLightKind>; };

}  // namespace sheaf
