// Media whose grids move. Grids are stored in their rest pose; an affine transform maps them to time t. Rays and points
// are transformed to the rest pose by its inverse. Distances along rays stay those of
// the world, because coefficients are per meter there: transformed directions are not of unit length if the motion
// stretches the grid.
#pragma once

#include "scene/tables/medium_lookup.h"
#include "scene/tables/motion_sample.h"

namespace sheaf {

/// The transform of the grids of medium `row` at a time in [0, 1]. Requires MotionView::media.
inline MotionSample<Scalar> medium_motion(const SceneView& scene, std::uint32_t row, float time) {
  return sample_motion<Scalar>(scene.motion, scene.motion.media[row], time);
}

/// Transforms a ray to the rest pose of the grids of medium `row`.
[[gnu::noinline]] inline void rest_ray(const SceneView& scene, std::uint32_t row, float time, Vec3f& origin,
                                       Vec3f& direction) {
  if (scene.motion.media[row].segment_count == 0) return;
  const MotionSample<Scalar> motion = medium_motion(scene, row, time);
  origin = motion.placed.object_point(origin);
  direction = motion.placed.object_vector(direction);
}

/// The SGGX matrix of medium `row` at a world-space point at a time in [0, 1]. Flakes turn with the grids: a matrix S
/// becomes M^-T S M^-1.
inline FlakeMatrix flake_matrix_at(const SceneView& scene, std::uint32_t row, Vec3f p, float time) {
  const MediumRow& medium = scene.media.rows[row];
  if (scene.motion.media == nullptr || scene.motion.media[row].segment_count == 0)
    return flake_matrix(scene, medium, p);
  const InstancePlacement<Scalar> placed = medium_motion(scene, row, time).placed;
  const FlakeMatrix s = flake_matrix(scene, medium, placed.object_point(p));
  // The columns of M^-1
  const Vec3f columns[3] = {placed.object_vector({1, 0, 0}), placed.object_vector({0, 1, 0}),
                            placed.object_vector({0, 0, 1})};
  const auto entry = [&](int i, int j) {
    const Vec3f v = columns[j];
    const auto& e = s.entries;
    const Vec3f rotated{e[0] * v.x + e[3] * v.y + e[4] * v.z, e[3] * v.x + e[1] * v.y + e[5] * v.z,
                        e[4] * v.x + e[5] * v.y + e[2] * v.z};
    return dot(columns[i], rotated);
  };
  return {{entry(0, 0), entry(1, 1), entry(2, 2), entry(0, 1), entry(0, 2), entry(1, 2)}};
}

}  // namespace sheaf
