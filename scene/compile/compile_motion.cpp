// Compiles motions: tabulates the transforms of moving instances, lights and cameras over the shutter. Those of media
// are in scene/compile/compile_medium_motion.cpp.
#include "scene/compile/scene_compiler.h"
#include "scene/tables/instance.h"

#include <algorithm>
#include <cmath>

namespace sheaf {

namespace {

/// Maximum error of linear interpolation between two steps, as a fraction of the size of the moving object.
constexpr double kMaxMotionError = 1e-4;

using Matrix = std::array<double, 12>;

Matrix rows_of(const Transform& transform) {
  Matrix out;
  for (std::size_t i = 0; i < 12; ++i) out[i] = transform.matrix().m[i / 4][i % 4];
  return out;
}

/// The largest distance between the images of a corner of the box under two matrices.
double distance(const Matrix& a, const Matrix& b, const GridBox& box) {
  double largest = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const double p[4] = {(corner & 1) != 0 ? box.max.x : box.min.x, (corner & 2) != 0 ? box.max.y : box.min.y,
                         (corner & 4) != 0 ? box.max.z : box.min.z, 1};
    double squared = 0;
    for (std::size_t row = 0; row < 3; ++row) {
      double difference = 0;
      for (std::size_t k = 0; k < 4; ++k) difference += (a[4 * row + k] - b[4 * row + k]) * p[k];
      squared += difference * difference;
    }
    largest = std::max(largest, squared);
  }
  return std::sqrt(largest);
}

double diagonal(const GridBox& box) { return double(length(box.max - box.min)); }

}  // namespace

std::vector<MotionStepRow> SceneCompiler::tabulate(const Motion& motion, const GridBox& box, double tolerance) const {
  const auto at = [&](double t) {
    const double time = in_.shutter.open + t * (in_.shutter.close - in_.shutter.open);
    return rows_of(motion.transform.at(time) * motion.before);
  };
  // Double the number of segments until interpolation is accurate. The times between steps are not symmetric, so that
  // keys between the steps are noticed.
  std::vector<Matrix> steps{at(0)};
  double error = kInfinity, change = 0;
  for (int segments = 1; moves() && error > tolerance && segments <= kMaxMotionSegments; segments *= 2) {
    steps.clear();
    error = 0;
    for (int i = 0; i <= segments; ++i) steps.push_back(at(double(i) / segments));
    for (std::size_t i = 0; i + 1 < steps.size(); ++i)
      for (const double t : {0.21, 0.5, 0.83}) {
        const Matrix exact = at((double(i) + t) / segments);
        Matrix between;
        for (std::size_t k = 0; k < 12; ++k) between[k] = (1 - t) * steps[i][k] + t * steps[i + 1][k];
        error = std::max(error, distance(between, exact, box));
        change = std::max({change, distance(exact, steps[0], box), distance(steps[i + 1], steps[0], box)});
      }
  }
  if (change == 0) steps.resize(1);
  // Convert to single precision
  std::vector<MotionStepRow> out;
  for (const Matrix& step : steps) {
    MotionStepRow row{};
    std::array<float, 12> rounded;
    for (std::size_t k = 0; k < 12; ++k) row.matrix[k] = rounded[k] = static_cast<float>(step[k]);
    if (!is_usable_instance(rounded)) throw SceneError("the transform of a moving object is singular or too extreme");
    out.push_back(row);
  }
  return out;
}

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
  const GridBox box{group.lower, group.upper};
  const std::vector<MotionStepRow> steps = tabulate(motion, box, kMaxMotionError * diagonal(box));
  const auto place = [&](const MotionStepRow& step) {
    return make_instance(std::to_array(step.matrix), group.range.first_shape, group.index);
  };
  // Bound the instance at all steps; in between it is in their convex hull
  InstanceRow row = place(steps[0]);
  for (const MotionStepRow& step : steps) {
    const InstanceBounds bounds = instance_bounds(place(step), group.lower, group.upper);
    if (!is_traceable(bounds.lower, bounds.upper)) throw SceneError("a moving object leaves the range of coordinates");
    grow(bounds.lower, bounds.upper);
  }
  // Add its lights, at rest
  row.first_light = static_cast<std::uint32_t>(out_->lights_.rows.size());
  if (!group.emitters.empty()) {
    InstanceRow resting = row;
    const Matrix at_rest = rows_of(rest);
    if (steps.size() > 1) {
      std::array<float, 12> matrix;
      std::transform(at_rest.begin(), at_rest.end(), matrix.begin(), [](double x) { return static_cast<float>(x); });
      resting = make_instance(matrix, group.range.first_shape, group.index);
    }
    for (const Emitter& emitter : group.emitters)
      add_area_light(out_->geometry_.shapes[emitter.shape], emitter, &resting);
    const InstanceBounds bounds = instance_bounds(resting, group.lower, group.upper);
    if (steps.size() > 1)
      add_light_motion(row.first_light, {motion.transform, motion.before * rest.inverse()},
                       {bounds.lower, bounds.upper});
  }
  // Add its row and its motion
  if (steps.size() > 1) {
    out_->motion_.instances.resize(out_->geometry_.instances.size() + 1);
    out_->motion_.instances.back() = add_motion(steps);
  }
  out_->geometry_.instances.push_back(row);
  out_->counts_.instanced_triangles += group.triangles;
}

MotionRow SceneCompiler::add_motion_from_rest(const Motion& motion, const GridBox& box) {
  std::vector<MotionStepRow> steps = tabulate(motion, box, kMaxMotionError * diagonal(box));
  const Matrix identity = rows_of({});
  if (steps.size() == 1 && std::equal(identity.begin(), identity.end(), steps[0].matrix)) return {};
  // An object that only lies elsewhere has two equal steps
  if (steps.size() == 1) steps.push_back(steps[0]);
  return add_motion(steps);
}

void SceneCompiler::add_light_motion(std::size_t first, const Motion& motion, const GridBox& box) {
  const MotionRow row = add_motion_from_rest(motion, box);
  if (row.segment_count == 0) return;
  out_->motion_.lights.resize(first);
  out_->motion_.lights.resize(out_->lights_.rows.size(), row);
}

void SceneCompiler::move_last_light(MotionId id) {
  const AnimatedTransform& motion = motion_of(id);
  const Vec3f size = Vec3f{1, 1, 1} * out_->radius_;
  add_light_motion(out_->lights_.rows.size() - 1, {motion, motion.reference().inverse()},
                   {out_->center_ - size, out_->center_ + size});
}

CameraDescription SceneCompiler::place_camera(CameraDescription camera, std::size_t index) {
  if (!camera.motion) return camera;
  const AnimatedTransform& motion = motion_of(*camera.motion);
  try {
    camera.to_world = motion.at(in_.shutter.open);
    // Directions must be accurate to a fraction of a pixel
    constexpr double kMaxCameraError = 2e-5;
    const Vec3f at = camera.to_world.point({0, 0, 0}), one{1, 1, 1};
    const auto steps = tabulate({motion, camera.to_world.inverse()}, {at - one, at + one}, kMaxCameraError);
    if (steps.size() == 1) return camera;
    out_->motion_.cameras.resize(index);
    out_->motion_.cameras.push_back(add_motion(steps));
  } catch (const SceneError& error) { throw at_place(camera.where, error); }
  return camera;
}

std::vector<Vec3f> SceneCompiler::places_of_camera(std::size_t index, Vec3f p) const {
  std::vector<Vec3f> places{p};
  if (index >= out_->motion_.cameras.size()) return places;
  const MotionRow& motion = out_->motion_.cameras[index];
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
