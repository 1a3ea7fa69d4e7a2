#include "scene/compile/render_origin.h"

#include <algorithm>
#include <cmath>

namespace sheaf {

namespace {

/// A scene is far from the origin if the camera is this many times closer to the nearest shape than to the origin:
/// coordinates then lose six bits.
constexpr double kFar = 64;

/// A point of a shape in its local space.
Vec3d point_on(const ShapeDescription& shape) {
  if (const auto* mesh = std::get_if<Mesh>(&shape.geometry))
    return mesh->positions.empty() ? Vec3d() : Vec3d(mesh->positions[0]);
  if (const auto* deforming = std::get_if<DeformingMesh>(&shape.geometry)) {
    const auto* mesh = std::get_if<Mesh>(&deforming->keys[0].mesh);
    const bool has_points = mesh != nullptr && !mesh->positions.empty();
    return deforming->keys[0].to_shape.precise_point(has_points ? Vec3d(mesh->positions[0]) : Vec3d());
  }
  if (const auto* sphere = std::get_if<SphereShape>(&shape.geometry)) return sphere->center;
  if (const auto* cylinder = std::get_if<CylinderShape>(&shape.geometry)) return cylinder->p0;
  if (const auto* curves = std::get_if<Curves>(&shape.geometry))
    return curves->points.empty() ? Vec3d() : Vec3d(curves->points[0].position);
  if (const auto* deforming = std::get_if<DeformingCurves>(&shape.geometry)) {
    const DeformingCurves::Key& key = deforming->keys[0];
    return key.to_shape.precise_point(key.curves.points.empty() ? Vec3d() : Vec3d(key.curves.points[0].position));
  }
  return {};
}

Vec3d placed_point(const ShapeDescription& shape) { return shape.to_world.precise_point(point_on(shape)); }

void move(Transform& to_world, const Transform& by) { to_world = by * to_world; }
void move(Vec3d& position, const Transform& by) { position = by.precise_point(position); }

void move(CameraDescription& camera, const Transform& by) {
  move(camera.to_world, by);
  if (auto* point = std::get_if<Vec3d>(&camera.target)) move(*point, by);
  if (auto* area = std::get_if<CameraDescription::TargetArea>(&camera.target)) move(area->to_world, by);
}

void move(VolumeInput& volume, const Transform& by) {
  if (auto* grid = std::get_if<GridVolumeDescription>(&volume)) move(grid->to_world, by);
}

void move(MediumDescription& medium, const Transform& by) {
  if (auto* coefficients = std::get_if<ExtinctionAlbedoDescription>(&medium.coefficients)) {
    move(coefficients->sigma_t, by);
    move(coefficients->albedo, by);
  } else if (auto* other = std::get_if<AbsorptionScatteringDescription>(&medium.coefficients)) {
    move(other->sigma_a, by);
    move(other->sigma_s, by);
  }
  if (medium.emission) move(*medium.emission, by);
  for (std::optional<GridVolumeDescription>* grid : {&medium.density, &medium.emission_factor, &medium.temperature})
    if (*grid) move((*grid)->to_world, by);
}

/// Moves a light or a texture: its member `to_world`, `position` or `grid`, see scene/lights/light.h and
/// scene/textures/texture.h.
template <class Model> void move_model(Model& model, const Transform& by) {
  std::visit(
      [&](auto& kind) {
        if constexpr (requires { kind.to_world; }) move(kind.to_world, by);
        if constexpr (requires { kind.position; }) move(kind.position, by);
        if constexpr (requires { kind.grid.to_world; }) move(kind.grid.to_world, by);
      },
      model);
}

}  // namespace

Vec3d render_origin(Vec3d camera, std::span<const Vec3d> points) {
  double nearest = double{kInfinity};
  for (const Vec3d point : points) nearest = std::min(nearest, length(point - camera));
  const double distance = length(camera);
  if (!(distance > kFar * nearest)) return {};
  // Round to a grid, so that a camera that moves a little keeps the origin
  const double cell = std::exp2(std::ceil(std::log2(std::max(nearest, distance * 0x1p-40))));
  const auto rounded = [&](double x) { return std::round(x / cell) * cell; };
  return {rounded(camera.x), rounded(camera.y), rounded(camera.z)};
}

Vec3d render_origin(const Description& description) {
  std::vector<Vec3d> points;
  points.reserve(description.shapes.size() + description.instances.size());
  for (const ShapeDescription& shape : description.shapes) points.push_back(placed_point(shape));
  std::vector<Vec3d> in_group;
  for (const ShapeGroup& group : description.groups)
    in_group.push_back(group.shapes.empty() ? Vec3d() : placed_point(group.shapes[0]));
  for (const InstanceDescription& instance : description.instances) {
    const Vec3d p = in_group.at(instance.group);
    const auto row = [&](std::size_t i) {
      const double* m = &instance.to_world[4 * i];
      return m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3];
    };
    points.push_back({row(0), row(1), row(2)});
  }
  return render_origin(description.camera.to_world.translation(), points);
}

Description moved_to(const Description& description, Vec3d origin) {
  const Transform by = Transform::translate(-origin);
  Description moved = description;
  move(moved.camera, by);
  for (CameraDescription& camera : moved.more_cameras) move(camera, by);
  for (ShapeDescription& shape : moved.shapes) move(shape.to_world, by);
  for (InstanceDescription& instance : moved.instances) {
    instance.to_world[3] -= origin.x;
    instance.to_world[7] -= origin.y;
    instance.to_world[11] -= origin.z;
  }
  for (AnimatedTransform& motion : moved.motions) motion = AnimatedTransform(by) * motion;
  for (MediumDescription& medium : moved.media) move(medium, by);
  for (PhaseDescription& phase : moved.phases)
    if (auto* flakes = std::get_if<SggxDescription>(&phase.model))
      if (auto* grid = std::get_if<GridVolumeDescription>(&flakes->matrix)) move(grid->to_world, by);
  for (LightDescription& light : moved.lights) move_model(light.model, by);
  for (TextureDescription& texture : moved.textures) move_model(texture.model, by);
  return moved;
}

}  // namespace sheaf
