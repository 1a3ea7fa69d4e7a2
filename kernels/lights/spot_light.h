// Spot lights with linear or smooth falloff; see SpotLightDescription.
#pragma once

#include "kernels/lights/point_light.h"
#include "scene/tables/shape.h"

namespace sheaf {

/// Loads the local frames of lights that have one.
template <class L> SHEAF_INLINE LightFrameRecord<L> load_frames(const LightQuery<L>& lights) {
  return gather_rows<L>(lights.scene.lights.frames, select(lights.active, lights.light.frame(), Uint<L>(0u)));
}

/// `Kind`: kSpot or kSmoothSpot.
template <LightKind Kind> struct SpotLight {
  static constexpr LightKind kKind = Kind;
  static constexpr LightHitKind kHitKind = LightHitKind::kNever;

  template <class L, ColorMode Mode>
  static SHEAF_INLINE LightSample<L> sample(const LightQuery<L>& lights, Vec3<L> from, const Random4<L>&,
                                            TextureQuery<L>& texture) {
    const LightFrameRecord<L> frame = load_frames<L>(lights);
    const Float<L> share = falloff<L>(lights, frame, frame.local_point(from), texture);
    LightSample<L> s = sample_position<L>(lights.light, from);
    s.radiance = s.radiance * share;
    s.valid = s.valid & (share > Float<L>(0.0f));
    return s;
  }

  /// Uniform directions in the cone, weighted by the falloff.
  template <class L, ColorMode Mode>
  static SHEAF_INLINE PhotonEmission<L> emit(const LightQuery<L>& lights, const Random4<L>&, const Random4<L>& b,
                                             TextureQuery<L>& texture) {
    using F = Float<L>;
    const LightFrameRecord<L> frame = load_frames<L>(lights);
    const F one_minus_cos = cone_one_minus_cos<L>(frame);
    const Vec3<L> local = square_to_cone<L>(b.x, b.y, one_minus_cos);
    const Vec3<L> along = frame.world_vector(local);
    const F share = falloff<L>(lights, frame, local, texture);
    const F pdf = world_pdf<L>(frame, along, F(0.5f * kInvPi) / max(one_minus_cos, F(1e-37f)));
    auto e = emit_from_position<L>(lights.light, normalize_any(along), pdf);
    e.flux = e.flux * share;
    e.valid = e.valid & (share > F(0.0f));
    return e;
  }

 private:
  static_assert(Kind == LightKind::kSpot || Kind == LightKind::kSmoothSpot);
  static constexpr bool kLinear = Kind == LightKind::kSpot;

  /// Falloff in [0, 1], without texture, in the direction `local`, a vector in the light's space.
  template <class L>
  static SHEAF_INLINE Float<L> falloff(const LightQuery<L>& lights, const LightFrameRecord<L>& frame, Vec3<L> local,
                                       TextureQuery<L>& texture) {
    using F = Float<L>;
    using U = Uint<L>;
    F x;
    if constexpr (kLinear) {
      // Compute the angle from its tangent, which is accurate near the axis.
      x = frame.cutoff - atan2(sqrt(local.x * local.x + local.y * local.y), local.z);
    } else {
      x = local.z / max(sqrt(dot(local, local)), F(1e-37f)) - frame.cutoff;
    }
    const F step = clamp(x * frame.slope, F(0.0f), F(1.0f));
    const auto textured = lights.active & (step > F(0.0f)) & (lights.light.texture != U(kNone));
    if (any(textured)) {
      const F scale = F(0.5f) * frame.cot_cutoff / max(local.z, F(1e-37f));
      const Vec2<L> uv{F(0.5f) + local.x * scale, F(0.5f) + local.y * scale};
      set_query<L>(textured, {uv, U(0u), U(0u), F(0.0f), F(0.0f)}, texture);
    }
    return kLinear ? step : step * step * (F(3.0f) - F(2.0f) * step);
  }

  template <class L> static SHEAF_INLINE Float<L> cone_one_minus_cos(const LightFrameRecord<L>& frame) {
    using F = Float<L>;
    if constexpr (!kLinear) return F(1.0f) - frame.cutoff;
    // 1 - cos of the cutoff angle c is 2 sin^2(c / 2).
    const F half = sincos_2pi<L>(clamp(frame.cutoff * F(0.25f * kInvPi), F(0.0f), F(0.25f))).sin;
    return F(2.0f) * half * half;
  }

  /// Converts `pdf`, per solid angle in the light's space, to world space. `along` is the world_vector() of a unit
  /// vector: a linear map of determinant D scales solid angles by |D| / |along|^3.
  template <class L>
  static SHEAF_INLINE Float<L> world_pdf(const LightFrameRecord<L>& frame, Vec3<L> along, Float<L> pdf) {
    const Float<L> l = length(along);
    return pdf * abs(frame.determinant()) * l * l * l;
  }
};

}  // namespace sheaf
