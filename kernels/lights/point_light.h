// Isotropic point lights, and code shared by all lights at a point.
#pragma once

#include "kernels/lights/light_kind.h"
#include "scene/lights/point_light.h"

namespace sheaf {

/// Light sample of a light at `position` with intensity LightRecord::radiance.
template <class L>
SHEAF_INLINE LightSample<L> sample_position(const LightRecord<L>& light, Vec3<L> position, Vec3<L> from) {
  using F = Float<L>;
  const Vec3<L> d = position - from;
  const F squared = dot(d, d);
  LightSample<L> s;
  s.valid = squared > F(1e-37f);
  const F inverse = F(1.0f) / select(s.valid, squared, F(1.0f));
  s.direction = d * sqrt(inverse);
  s.target = position;
  s.radiance = light.radiance * inverse;
  s.pdf_solid_angle = F(1.0f);
  return s;
}

/// A photon from that position.
template <class L>
SHEAF_INLINE PhotonEmission<L> emit_from_position(const LightRecord<L>& light, Vec3<L> position, Vec3<L> direction,
                                                  Float<L> pdf_direction) {
  using F = Float<L>;
  PhotonEmission<L> e;
  e.origin = position;
  e.direction = direction;
  e.pdf_position = F(1.0f);
  e.pdf_direction = pdf_direction;
  e.valid = pdf_direction > F(0.0f);
  e.flux = light.radiance * (F(1.0f) / select(e.valid, pdf_direction, F(1.0f)));
  return e;
}

struct PointLight {
  using Kind = PointLightKind;
  static constexpr LightHitKind kHitKind = LightHitKind::kNever;

  template <class L, ColorMode kMode>
  static SHEAF_INLINE LightSample<L> sample(const LightQuery<L>& lights, Vec3<L> from, const Random4<L>&,
                                            TextureQuery<L>&) {
    return sample_position<L>(lights.light, lights.light.template data<PointLightData>().position, from);
  }

  template <class L, ColorMode kMode>
  static SHEAF_INLINE PhotonEmission<L> emit(const LightQuery<L>& lights, const Random4<L>&, const Random4<L>& b,
                                             TextureQuery<L>&) {
    return emit_from_position<L>(lights.light, lights.light.template data<PointLightData>().position,
                                 square_to_sphere<L>(b.x, b.y), Float<L>(kUniformSpherePdf));
  }
};

template <> struct LightOf<PointLightKind> { using Type = PointLight; };

}  // namespace sheaf
