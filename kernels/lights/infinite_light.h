// What lights that shine from outside of the scene have in common.
#pragma once

#include "core/frame.h"
#include "kernels/lights/light_kind.h"

namespace sheaf {

/// Where infinite lights' photons start, in radii of the bounding sphere from its centre.
inline constexpr float kDiskDistance = 1.05f;

/// Where a shadow ray to such a light ends.
template <class L> SHEAF_INLINE Vec3<L> beyond_scene(const SceneView& scene, Vec3<L> from, Vec3<L> direction) {
  return from + direction * Float<L>(2.1f * scene.radius);
}

/// The radius, metres, of the sphere around SceneView::center that photons from outside must cover: a medium without an
/// end of its own reaches a little beyond the scene.
inline float covered_radius(const SceneView& scene) {
  return scene.outer_medium != 0 && scene.medium_radius < kInfinity ? scene.medium_radius : scene.radius;
}

/// A photon through the disk across `direction` that covers that sphere (Pharr et al., 4th ed., section 12.5.2).
/// `radiance` comes along it, or irradiance if the direction is the only one. By a.y and a.z.
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
