#include "scene/tables/camera.h"

#include <cmath>

namespace sheaf {

namespace {

void check(const CameraDescription& d) {
  if (!(d.near_clip >= 0.0f && d.near_clip < d.far_clip))
    throw SceneError(d.where, "clip distances must be in order and not negative, found " + std::to_string(d.near_clip) +
                                  " (near) and " + std::to_string(d.far_clip) + " (far)");
  if (!(d.aperture_radius >= 0.0f && d.aperture_radius < kInfinity))
    throw SceneError(d.where,
                     "radius of the aperture must not be negative, found " + std::to_string(d.aperture_radius));
  if (!(d.focus_distance > 0.0f))
    throw SceneError(d.where, "focus distance must be positive, found " + std::to_string(d.focus_distance));
}

/// The vector whose product with a point, seen from the origin, is the point's z: across the film, and 1 with `corner`.
Vec3f z_axis_of(const Camera& camera) {
  const Vec3f across = cross(camera.origin_dx + camera.dx, camera.origin_dy + camera.dy);
  return across * (1.0f / dot(across, camera.corner));
}

}  // namespace

double half_width_of(float fov, CameraDescription::FovAxis axis, double width, double height,
                     const SourceLocation& where) {
  if (!(fov > 0.0f && fov < 180.0f))
    throw SceneError(where, "field of view must lie between 0 and 180 degrees, found " + std::to_string(fov));
  const double t = std::tan(0.5 * fov * (3.14159265358979323846 / 180.0));
  using Axis = CameraDescription::FovAxis;
  switch (axis) {
    case Axis::kX: return t;
    case Axis::kY: return t * width / height;
    case Axis::kDiagonal: return t * width / std::hypot(width, height);
    case Axis::kSmaller: return width <= height ? t : t * width / height;
    case Axis::kLarger: return width >= height ? t : t * width / height;
  }
  return t;
}

Camera make_camera(const CameraDescription& description, int width, int height) {
  check(description);
  const bool orthographic = description.projection == CameraDescription::Projection::kOrthographic;
  const double half =
      orthographic ? 1.0
                   : half_width_of(description.fov, description.fov_axis, width, height, description.where);
  const double step = 2.0 * half / width;
  const auto to_world = [&description](double x, double y, double z) {
    return description.to_world.vector({static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)});
  };
  const double left = half * (1.0 - 2.0 * description.principal_point_x);
  const double top = half * height / width * (1.0 - 2.0 * description.principal_point_y);
  Camera camera;
  camera.near_clip = description.near_clip;
  camera.clip_range = description.far_clip - description.near_clip;
  if (orthographic) {
    camera.origin = description.to_world.point({static_cast<float>(left), static_cast<float>(top), 0});
    camera.origin_dx = to_world(-step, 0, 0);
    camera.origin_dy = to_world(0, -step, 0);
    camera.corner = to_world(0, 0, 1.0);
    camera.z_axis = z_axis_of(camera);
    return camera;
  }
  camera.origin = description.to_world.point({0, 0, 0});
  camera.corner = to_world(left, top, 1.0);
  camera.dx = to_world(-step, 0, 0);
  camera.dy = to_world(0, -step, 0);
  camera.lens_x = to_world(description.aperture_radius, 0, 0);
  camera.lens_y = to_world(0, description.aperture_radius, 0);
  camera.inverse_focus_distance = 1.0f / description.focus_distance;
  camera.z_axis = z_axis_of(camera);
  return camera;
}

}  // namespace sheaf
