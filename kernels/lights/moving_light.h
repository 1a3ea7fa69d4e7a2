// Moving lights. Lights are stored in their rest pose; an affine transform maps them to time t. Reference points are
// transformed to the rest pose by its inverse, and samples back to time t.
//
// A linear map M takes a solid angle around the unit vector d to |det M| / |M d|^3 times that solid angle, and a pencil
// of rays of throughput dA cos dw to (det M)^2 / |M d|^4 times that throughput. Both factors are 1 for rotations.
#pragma once

#include "kernels/lights/light_kind.h"
#include "scene/tables/motion_sample.h"

namespace sheaf {

/// The transforms of lights `light` at times in [0, 1]. Requires MotionView::lights.
template <class L>
SHEAF_INLINE MotionSample<L> light_motion(const SceneView& scene, Uint<L> light, Mask<L> active, Float<L> time) {
  return sample_motion<L>(scene.motion, load_motion<L>(scene.motion.lights, light, active), time);
}

/// Transforms a reference point to the rest pose of the light.
template <class L> SHEAF_INLINE Vec3<L> rest_point(const MotionSample<L>& motion, Vec3<L> p) {
  return select<L>(motion.moves, motion.placed.object_point(p), p);
}

/// Factor from a pdf per solid angle around the unit vector `direction`, for the light at rest, to that of the moved
/// light; `stretched` is the length of the transformed vector.
template <class L> SHEAF_INLINE Float<L> solid_angle_factor(const InstancePlacement<L>& placed, Float<L> stretched) {
  return stretched * stretched * stretched / abs(placed.determinant);
}

/// Transforms samples from the rest pose of lights to their pose at the time. `light`: rows.
template <class L>
SHEAF_INLINE void move_light_sample(const SceneView& scene, const MotionSample<L>& motion, Uint<L> light,
                                    LightSample<L>& s) {
  using F = Float<L>;
  const Vec3<L> direction = motion.placed.vector(s.direction);
  const F stretched = length(direction), inverse = F(1.0f) / stretched;
  const auto moves = motion.moves;
  s.direction = select<L>(moves, direction * inverse, s.direction);
  s.normal = select<L>(moves, motion.placed.normal(s.normal), s.normal);
  s.target = select<L>(moves, motion.placed.point(s.target), s.target);
  F factor = solid_angle_factor<L>(motion.placed, stretched);
  // Pdfs of points in volumes are per length as well
  factor = select(s.target_medium != Uint<L>(kNone), factor * inverse, factor);
  s.pdf_solid_angle = select(moves & !s.delta, s.pdf_solid_angle * factor, s.pdf_solid_angle);
  // The intensity of lights at a point holds for distances in the world.
  const auto at_point = moves & s.delta & (light < Uint<L>(scene.lights.bounded_count));
  s.radiance = select<L>(at_point, s.radiance * (inverse * inverse), s.radiance);
}

/// Moves a ray that has hit lights, and their normals, to where the lights would be at rest. Returns the factor from
/// the pdf there to the pdf per solid angle of the moved light.
template <class L> SHEAF_INLINE Float<L> rest_hit(const MotionSample<L>& motion, LightHit<L>& hit) {
  using F = Float<L>;
  const InstancePlacement<L>& placed = motion.placed;
  const Vec3<L> direction = placed.object_vector(hit.direction);
  const F scale = length(direction);
  const auto moves = motion.moves;
  hit.from = select<L>(moves, placed.object_point(hit.from), hit.from);
  hit.direction = select<L>(moves, direction / scale, hit.direction);
  hit.t = select(moves, hit.t * scale, hit.t);
  hit.ng = select<L>(moves, normalize(placed.object_normal(hit.ng)), hit.ng);
  return select(moves, solid_angle_factor<L>(placed, F(1.0f) / scale), F(1.0f));
}

/// Moves photons from lights at rest to where the lights are. Volumes emit in all directions alike, however they are
/// stretched.
template <class L>
SHEAF_INLINE void move_photon(const MotionSample<L>& motion, PhotonEmission<L>& e, Mask<L> on_shape) {
  using F = Float<L>;
  const Vec3<L> direction = motion.placed.vector(e.direction);
  const F squared = dot(direction, direction), ratio = motion.placed.determinant / squared;
  const auto in_volume = motion.moves & (e.medium != Uint<L>(kNone));
  e.origin = select<L>(motion.moves, motion.placed.point(e.origin), e.origin);
  e.direction = select<L>(motion.moves & !in_volume, direction / sqrt(squared), e.direction);
  e.normal = select<L>(motion.moves, motion.placed.normal(e.normal), e.normal);
  e.flux = select<L>(motion.moves & on_shape, e.flux * (ratio * ratio), e.flux);
  e.flux = select<L>(in_volume, e.flux * abs(motion.placed.determinant), e.flux);
}

}  // namespace sheaf
