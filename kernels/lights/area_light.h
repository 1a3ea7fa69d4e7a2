// Code shared by area lights: from a point on the light to a light sample or an emitted photon.
#pragma once

#include "core/math/frame.h"
#include "kernels/lights/light_kind.h"
#include "scene/surfaces/shape.h"

namespace sheaf {

/// A point on an area light.
template <class L> struct LightPoint {
  SurfacePoint<L> y;           ///< p, ng and offset only
  typename L::Float pdf_area;  ///< per area in world space
};

/// Light sample for a point on an area light: converts its pdf from area to solid angle and handles one-sided and
/// two-sided emission.
template <class L>
SHEAF_INLINE LightSample<L> sample_towards(Vec3<L> from, const LightPoint<L>& point, const LightRecord<L>& light) {
  using F = Float<L>;
  const SurfacePoint<L>& y = point.y;
  LightSample<L> s;
  const Vec3<L> d = y.p - from;
  const F squared = dot(d, d);
  s.direction = d * (F(1.0f) / sqrt(max(squared, F(1e-37f))));
  const F cos_front = -dot(s.direction, y.ng);
  const auto behind = light.is_two_sided() & (cos_front < F(0.0f));
  const F cos_light = select(behind, -cos_front, cos_front);
  s.valid = (cos_light > F(1e-6f)) & (squared > F(0.0f)) & !light.is_along_normal();
  s.pdf_solid_angle = point.pdf_area * squared / select(s.valid, cos_light, F(1.0f));
  s.target = y.p + y.ng * select(behind, -y.offset, y.offset);
  s.radiance = light.radiance;
  s.normal = y.ng;
  return s;
}

/// Solid-angle pdf of a point that is sampled with `pdf_area` per area.
template <class L> SHEAF_INLINE Float<L> pdf_seen(Float<L> pdf_area, const LightHit<L>& hit) {
  using F = Float<L>;
  const F cos_light = abs(dot(hit.direction, hit.ng));
  return pdf_area * hit.t * hit.t / max(cos_light, F(1e-6f));
}

/// Emits a photon from a point on an area light, with a cosine-distributed direction (Jensen, "Realistic Image
/// Synthesis Using Photon Mapping", 2001, section 5.2). All photons of an untextured light without non-uniform scaling
/// then carry the same flux. Two-sided lights emit from either side. Lights that emit along the normal only use that
/// direction.
template <class L>
SHEAF_INLINE PhotonEmission<L> emit_from(const LightPoint<L>& at, const LightRecord<L>& light, const Random4<L>& b) {
  using F = Float<L>;
  const Vec3<L> local = square_to_cosine_hemisphere<L>(b.x, b.y);
  PhotonEmission<L> e;
  const auto parallel = light.is_along_normal(), two_sided = light.is_two_sided();
  const F side = select(two_sided & (b.z < F(0.5f)), F(-1.0f), F(1.0f)), sides = select(two_sided, F(2.0f), F(1.0f));
  const Vec3<L> outwards = at.y.ng * side;
  e.origin = at.y.p + outwards * at.y.offset;
  e.direction = select<L>(parallel, outwards, Frame<L>::from_normal(outwards).to_world(local));
  e.pdf_position = at.pdf_area;
  e.pdf_direction = select(parallel, F(1.0f), cosine_hemisphere_pdf_solid_angle(local.z)) / sides;
  e.flux = light.radiance * (select(parallel, F(1.0f), F(kPi)) * sides / at.pdf_area);
  e.valid = parallel | (local.z > F(0.0f));
  e.normal = outwards;
  return e;
}

}  // namespace sheaf
