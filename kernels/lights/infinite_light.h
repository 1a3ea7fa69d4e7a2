// Code shared by lights at infinity.
#pragma once

#include "core/math/frame.h"
#include "kernels/lights/light_kind.h"

namespace sheaf {

/// Distance of the photons' start from the center of the bounding sphere, in radii.
inline constexpr float kDiskDistance = 1.05f;

/// End of a shadow ray to such a light.
template <class L> SHEAF_INLINE Vec3<L> beyond_scene(const SceneView& scene, Vec3<L> from, Vec3<L> direction) {
  return from + direction * Float<L>(2.1f * scene.radius);
}

/// Radius, in meters, of the sphere around SceneView::center that photons from infinity must cover. An unbounded outer
/// medium extends a little beyond the scene.
inline float covered_radius(const SceneView& scene) {
  return scene.media.outer_medium != 0 && scene.media.outer_radius < kInfinity ? scene.media.outer_radius
                                                                               : scene.radius;
}

/// Emits a photon through the disk perpendicular to `direction` that covers that sphere (Pharr et al., 4th ed., section
/// 12.5.2). `radiance` arrives along `direction`; for a delta light it is irradiance. Uses a.y and a.z.
template <class L>
SHEAF_INLINE PhotonEmission<L> emit_from_infinity(const SceneView& scene, Vec3<L> direction,
                                                  const Spectrum<L>& radiance, Float<L> pdf_direction,
                                                  const Random4<L>& a) {
  using F = Float<L>;
  const Vec2<L> on_disk = square_to_disk<L>(a.y, a.z);
  const float covered = covered_radius(scene);
  const F radius(covered), area(kPi * covered * covered);
  PhotonEmission<L> e;
  e.direction = direction;
  e.origin = broadcast<L>(scene.center) +
             Frame<L>::from_normal(direction).to_world({on_disk.x, on_disk.y, F(-kDiskDistance)}) * radius;
  e.pdf_position = F(1.0f) / area;
  e.pdf_direction = pdf_direction;
  e.valid = pdf_direction > F(0.0f);
  e.flux = radiance * (area / select(e.valid, pdf_direction, F(1.0f)));
  return e;
}

}  // namespace sheaf
