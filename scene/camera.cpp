#include "scene/camera.h"

#include <cmath>

namespace sheaf {

namespace {

/// tan of half the horizontal field of view.
double half_width(const CameraDescription& d, double width, double height) {
  if (!(d.fov > 0.0f && d.fov < 180.0f))
    throw SceneError(d.where, "field of view must lie between 0 and 180 degrees, found " + std::to_string(d.fov));
  const double t = std::tan(0.5 * d.fov * (3.14159265358979323846 / 180.0));
  using Axis = CameraDescription::FovAxis;
  switch (d.fov_axis) {
    case Axis::kX: return t;
    case Axis::kY: return t * width / height;
    case Axis::kDiagonal: return t * width / std::hypot(width, height);
    case Axis::kSmaller: return width <= height ? t : t * width / height;
    case Axis::kLarger: return width >= height ? t : t * width / height;
  }
  return t;
}

}  // namespace

Camera make_camera(const CameraDescription& description, int width, int height) {
  const double half = half_width(description, width, height), step = 2.0 * half / width;
  const auto to_world = [&description](double x, double y, double z) {
    return description.to_world.vector({static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)});
  };
  Camera camera;
  camera.origin = description.to_world.point({0, 0, 0});
  camera.corner = to_world(half, half * height / width, 1.0);
  camera.dx = to_world(-step, 0, 0);
  camera.dy = to_world(0, -step, 0);
  return camera;
}

}  // namespace sheaf
