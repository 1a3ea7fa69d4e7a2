#include "scene/dialects/common/moving_groups.h"

#include "scene/tables/instance_transform.h"

#include <algorithm>
#include <iterator>
#include <map>

namespace sheaf {

namespace {

/// A group of shapes that had the same motion inside of another group.
struct MovingGroup {
  std::uint32_t group;
  MotionId motion;
};

/// Moves the shapes with a motion to new groups, at rest.
std::vector<MovingGroup> take_moving_shapes(Description& description, std::uint32_t from) {
  std::map<MotionId, std::uint32_t> groups;
  std::vector<ShapeDescription> still;
  for (ShapeDescription& shape : std::exchange(description.groups[from].shapes, {})) {
    if (!shape.motion) {
      still.push_back(std::move(shape));
      continue;
    }
    const auto [found, is_new] = groups.emplace(*shape.motion, static_cast<std::uint32_t>(description.groups.size()));
    if (is_new) description.groups.push_back({{}, description.groups[from].id, description.groups[from].where});
    shape.to_world = Transform();
    shape.motion.reset();
    description.groups[found->second].shapes.push_back(std::move(shape));
  }
  description.groups[from].shapes = std::move(still);
  std::vector<MovingGroup> moving;
  for (const auto& [motion, group] : groups) moving.push_back({group, motion});
  return moving;
}

/// The placement of an instance.
Placement placement_of(const InstanceDescription& instance, const std::vector<AnimatedTransform>& motions) {
  if (instance.motion) return Placement(motions[static_cast<std::size_t>(*instance.motion)]);
  Matrix4 matrix;
  for (std::size_t i = 0; i < 12; ++i) matrix.m[i / 4][i % 4] = instance.to_world[i];
  return Placement(Transform(matrix));
}

/// The placement of a shape that moves by `inner` within an instance; empty if it is singular or too extreme.
std::optional<Placement> moving_placement(const Placement& outer, const AnimatedTransform& inner) {
  try {
    Placement placed(outer.motion.value_or(AnimatedTransform(outer.to_world)) * inner);
    if (is_usable_placement(placed)) return placed;
  } catch (const SceneError&) {
    // Too extreme for double precision
  }
  return std::nullopt;
}

}  // namespace

std::array<double, 12> rows_of(const Transform& transform) {
  std::array<double, 12> rows;
  for (std::size_t i = 0; i < 12; ++i) rows[i] = transform.matrix().m[i / 4][i % 4];
  return rows;
}

bool is_usable_placement(const Placement& placement) {
  if (!placement.motion) return is_usable_instance(rounded_rows(rows_of(placement.to_world)));
  const std::vector<double> times = placement.motion->key_times();
  return std::all_of(times.begin(), times.end(), [&](double time) {
    return is_usable_instance(rounded_rows(rows_of(placement.motion->at(time))));
  });
}

void separate_moving_shapes(Description& description, ErrorSink& errors) {
  // Split the groups
  std::map<std::uint32_t, std::vector<MovingGroup>> split;
  const auto count = static_cast<std::uint32_t>(description.groups.size());
  const auto moves = [](const ShapeDescription& shape) { return shape.motion.has_value(); };
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::vector<ShapeDescription>& shapes = description.groups[i].shapes;
    if (std::any_of(shapes.begin(), shapes.end(), moves)) split.emplace(i, take_moving_shapes(description, i));
  }
  if (split.empty()) return;
  // Add instances of the new groups
  std::vector<InstanceDescription> instances;
  for (const InstanceDescription& instance : description.instances) {
    const auto found = split.find(instance.group);
    if (found == split.end() || !description.groups[instance.group].shapes.empty()) instances.push_back(instance);
    if (found == split.end()) continue;
    const Placement outer = placement_of(instance, description.motions);
    for (const MovingGroup& moving : found->second) {
      const AnimatedTransform& inner = description.motions[static_cast<std::size_t>(moving.motion)];
      const std::optional<Placement> placed = moving_placement(outer, inner);
      if (!placed) {
        errors.report(SceneError(description.groups[moving.group].where,
                                 "an instance of a shape that moves has a transform that is singular or too extreme",
                                 SceneErrorCode::kOutOfRange),
                      "instance ignored");
        continue;
      }
      instances.push_back({rows_of(placed->to_world), moving.group, add_motion(description.motions, *placed)});
    }
  }
  description.instances = std::move(instances);
}

}  // namespace sheaf
