// Compiles motions: tabulates the transforms of moving instances, lights and cameras over the shutter. Those of media
// are in scene/compile/media/compile_medium_motion.cpp.
#include "scene/compile/scene_compiler.h"
#include "scene/lights/light_bounds.h"
#include "scene/lights/light_powers.h"
#include "scene/tables/instance.h"

#include <algorithm>
#include <cmath>

namespace sheaf {

namespace {

std::array<float, 12> single_rows(const Transform& transform) {
  std::array<float, 12> out;
  for (std::size_t i = 0; i < 12; ++i) out[i] = static_cast<float>(transform.matrix().m[i / 4][i % 4]);
  return out;
}

/// Some of the steps of an instance, for the ray offsets of its lights.
std::vector<LightInstance::Step> steps_for_offsets(const std::vector<MotionStepRow>& steps) {
  constexpr std::size_t kParts = 8;
  std::vector<LightInstance::Step> out;
  const std::size_t segments = steps.size() - 1;
  for (std::size_t i = 0; i <= std::min(segments, kParts); ++i) {
    const std::size_t step = segments <= kParts ? i : i * segments / kParts, before = std::min(step, segments - 1);
    LightInstance::Step added{make_instance(std::to_array(steps[step].matrix), 0, 0), {}};
    for (std::size_t k = 0; k < 12; ++k)
      added.speed[k] = std::fabs(steps[before + 1].matrix[k] - steps[before].matrix[k]) * static_cast<float>(segments);
    out.push_back(added);
  }
  return out;
}

}  // namespace

MotionRow SceneCompiler::add_motion(const std::vector<MotionStepRow>& steps) {
  std::vector<MotionStepRow>& all = out_->motion_.steps;
  if (all.size() + steps.size() > kMaxWords / 16) throw SceneError("too many moving objects");
  const MotionRow row{static_cast<std::uint32_t>(all.size()), static_cast<std::uint32_t>(steps.size() - 1)};
  all.insert(all.end(), steps.begin(), steps.end());
  return row;
}

void SceneCompiler::add_moving_shapes() {
  const auto count = [&] { return static_cast<std::uint32_t>(out_->geometry_.instances.size()); };
  out_->motion_.first_moving_shape = count();
  for (const ShapeDescription* shape : moving_shapes_) {
    const AnimatedTransform& motion = motion_of(*shape->motion);
    shape_motion_ = &motion;
    const GroupContents group = add_group(std::span(shape, 1), {});
    shape_motion_ = nullptr;
    if (group.range.shape_count == 0) continue;
    try {
      add_moving_instance(group, {motion, motion.reference().inverse()}, {});
    } catch (const SceneError& error) { throw at_place(shape->where, error); }
  }
  out_->motion_.end_of_moving_shapes = count();
}

void SceneCompiler::add_moving_instance(const GroupContents& group, const Motion& motion, const Transform& rest) {
  const std::vector<MotionStepRow> steps =
      tabulate_motion(motion, MotionProbes::of_box({group.lower, group.upper}), in_.shutter);
  const auto place = [&](const auto& matrix) { return make_instance(matrix, group.range.first_shape, group.index); };
  // Bound the instance at all steps; in between it is in their convex hull
  InstanceRow row = place(std::to_array(steps[0].matrix));
  for (const MotionStepRow& step : steps) {
    const InstanceBounds bounds = instance_bounds(place(std::to_array(step.matrix)), group.lower, group.upper);
    if (!is_traceable(bounds.lower, bounds.upper)) throw SceneError("a moving object leaves the range of coordinates");
    grow(bounds.lower, bounds.upper);
  }
  // Add its lights, at rest, with the motion of the instance
  row.first_light = static_cast<std::uint32_t>(out_->lights_.rows.size());
  if (!group.emitters.empty()) {
    LightInstance instance{row};
    if (steps.size() > 1) instance = {place(single_rows(rest)), steps_for_offsets(steps)};
    for (const Emitter& emitter : group.emitters)
      add_area_light(out_->geometry_.shapes[emitter.shape], emitter, &instance);
    if (steps.size() > 1)
      add_light_motion(row.first_light, add_motion(steps_from_rest(steps, std::to_array(instance.rest.to_world))));
  }
  // Add its row and its motion
  if (steps.size() > 1) {
    out_->motion_.instances.resize(out_->geometry_.instances.size() + 1);
    out_->motion_.instances.back() = add_motion(steps);
  }
  out_->geometry_.instances.push_back(row);
  out_->counts_.instanced_triangles += group.triangles;
}

MotionRow SceneCompiler::add_motion_from_rest(const AnimatedTransform& motion, const MotionProbes& probes) {
  std::vector<MotionStepRow> steps = tabulate_motion({motion, motion.reference().inverse()}, probes, in_.shutter);
  const std::array<float, 12> identity = single_rows({});
  if (steps.size() == 1 && std::equal(identity.begin(), identity.end(), steps[0].matrix)) return {};
  // An object that only lies elsewhere has two equal steps
  if (steps.size() == 1) steps.push_back(steps[0]);
  return add_motion(steps);
}

void SceneCompiler::add_light_motion(std::size_t first, const MotionRow& row) {
  if (row.segment_count == 0) return;
  out_->motion_.lights.resize(first);
  out_->motion_.lights.resize(out_->lights_.rows.size(), row);
}

void SceneCompiler::move_last_light(MotionId id) {
  const LightRow& light = out_->lights_.rows.back();
  const auto row = static_cast<std::uint32_t>(out_->lights_.rows.size() - 1);
  MotionProbes probes = MotionProbes::of_directions();
  if (!is_infinite(light)) {
    const LightBounds bounds = bounds_of_light(out_->make_view(), row, 1);
    for (const Vec3f p : {bounds.lower, bounds.upper}) probes.add_point(p);
  }
  add_light_motion(row, add_motion_from_rest(motion_of(id), probes));
}

CameraDescription SceneCompiler::place_camera(CameraDescription camera, std::size_t index) {
  if (!camera.motion) return camera;
  const AnimatedTransform& motion = motion_of(*camera.motion);
  try {
    camera.to_world = motion.at(in_.shutter.open);
    // Directions must be accurate to a fraction of a pixel
    constexpr double kMaxDirectionError = 2e-5;
    MotionProbes probes = MotionProbes::of_directions(kMaxDirectionError);
    probes.add_point(camera.to_world.point({0, 0, 0}));
    const auto steps = tabulate_motion({motion, camera.to_world.inverse()}, probes, in_.shutter);
    if (steps.size() == 1) return camera;
    out_->motion_.cameras.resize(index);
    out_->motion_.cameras.push_back(add_motion(steps));
  } catch (const SceneError& error) { throw at_place(camera.where, error); }
  return camera;
}

std::vector<Vec3f> SceneCompiler::places_along(const MotionRow& motion, Vec3f p) const {
  std::vector<Vec3f> places{p};
  for (std::uint32_t i = 0; motion.segment_count > 0 && i <= motion.segment_count; ++i)
    places.push_back(InstancePlacement<Scalar>(step_placement(motion.first_step + i)).point(p));
  return places;
}

InstanceRow SceneCompiler::step_placement(std::uint32_t step) const {
  return make_instance(std::to_array(out_->motion_.steps[step].matrix), 0, 0);
}

LightBounds SceneCompiler::moved_bounds(LightBounds bounds, std::size_t light) const {
  if (light >= out_->motion_.lights.size() || out_->motion_.lights[light].segment_count == 0) return bounds;
  const MotionRow& motion = out_->motion_.lights[light];
  LightBounds moved = bounds;
  moved.lower = {kInfinity, kInfinity, kInfinity};
  moved.upper = {-kInfinity, -kInfinity, -kInfinity};
  const auto axis_at = [&](std::uint32_t i) {
    return normalize(InstancePlacement<Scalar>(step_placement(motion.first_step + i)).vector(bounds.axis));
  };
  moved.axis = axis_at(motion.segment_count / 2);
  double widest = 0;
  for (std::uint32_t i = 0; i <= motion.segment_count; ++i) {
    const InstanceBounds box = instance_bounds(step_placement(motion.first_step + i), bounds.lower, bounds.upper);
    grow_box(moved.lower, moved.upper, box.lower, box.upper);
    widest = std::max(widest, std::acos(std::clamp(double(dot(moved.axis, axis_at(i))), -1.0, 1.0)));
  }
  // Widen the cone of normals by the largest turn of its axis
  const double angle = std::acos(std::clamp(double(bounds.cos_theta_o), -1.0, 1.0)) + widest;
  moved.cos_theta_o = static_cast<float>(std::cos(std::min(angle, double(kPi))));
  return moved;
}

void SceneCompiler::finish_motion() {
  MotionTables& motion = out_->motion_;
  if (!motion.instances.empty()) motion.instances.resize(out_->geometry_.instances.size());
  if (!motion.lights.empty()) motion.lights.resize(out_->lights_.rows.size());
  if (!motion.cameras.empty()) motion.cameras.resize(cameras_.size());
  if (!motion.media.empty()) motion.media.resize(out_->media_.rows.size());
  motion.shutter_ramp = in_.shutter.ramp;
}

}  // namespace sheaf
