// Cameras that move: rays and projections at a given time.
#pragma once

#include "scene/tables/motion_sample.h"

namespace sheaf {

/// The transforms of camera `index` from its pose in the table of cameras to its pose at times in [0, 1]. Requires
/// MotionView::cameras.
template <class L>
SHEAF_INLINE MotionSample<L> camera_motion(const SceneView& scene, std::uint32_t index, Float<L> time) {
  using U = Uint<L>;
  const MotionRow& row = scene.motion.cameras[index];
  return sample_motion<L>(scene.motion, {U(row.first_step), U(row.segment_count)}, time);
}

/// Transforms points from the pose of camera `index` at the time to its pose in the table.
template <class L>
SHEAF_INLINE Vec3<L> camera_rest_point(const SceneView& scene, std::uint32_t index, Vec3<L> p, Float<L> time) {
  if (scene.motion.cameras == nullptr) return p;
  const MotionSample<L> motion = camera_motion<L>(scene, index, time);
  return select<L>(motion.moves, motion.placed.object_point(p), p);
}

/// Moves the rays of a camera at rest to where the camera is.
template <class L> SHEAF_INLINE CameraRay<L> move_camera_ray(const MotionSample<L>& motion, const CameraRay<L>& ray) {
  const Vec3<L> direction = motion.placed.vector(ray.direction);
  const Float<L> stretched = length(direction);
  return {select<L>(motion.moves, motion.placed.point(ray.origin), ray.origin),
          select<L>(motion.moves, direction / stretched, ray.direction),
          select(motion.moves, ray.t_max * stretched, ray.t_max)};
}

/// Projects points to the film of the first camera, through the point `lens` of the unit disk, at times in [0, 1].
template <class L> SHEAF_INLINE CameraView<L> view_at(const SceneView& scene, Vec3<L> p, Vec2<L> lens, Float<L> time) {
  const Camera& camera = scene.sensor.camera;
  if (scene.motion.cameras == nullptr) return camera.view<L>(p, lens.x, lens.y);
  const MotionSample<L> motion = camera_motion<L>(scene, 0, time);
  const InstancePlacement<L>& placed = motion.placed;
  const Vec3<L> at_rest = camera_rest_point<L>(scene, 0, p, time);
  CameraView<L> view = camera.view<L>(at_rest, lens.x, lens.y);
  // The cross section of a pencil of rays scales by the determinant over the stretch along it
  const Float<L> stretched = length(placed.vector(normalize(view.target - at_rest)));
  view.importance = select(motion.moves, view.importance * stretched / abs(placed.determinant), view.importance);
  view.target = select<L>(motion.moves, placed.point(view.target), view.target);
  return view;
}

}  // namespace sheaf
