// Framing of models: the nearest eye point whose frustum, narrowed to two thirds, contains every vertex.
#include "scene/dialects/model/framing.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <tuple>

namespace sheaf {

namespace {

/// Part of the image that the model fills along one axis.
constexpr double kFill = 2.0 / 3;
/// Least distance of the camera from the model, in radii of the model. It matters for very wide fields of view.
constexpr double kClearance = 0.05;

using PointVisitor = std::function<void(Vec3d)>;

void visit(const Mesh& mesh, const Transform& to_world, const PointVisitor& visitor) {
  for (const Vec3f p : mesh.positions) visitor(to_world.precise_point(p));
}

/// Calls the visitor for the vertices of a shape. Models consist of meshes.
void visit(const ShapeDescription& shape, const Transform& to_world, const PointVisitor& visitor) {
  if (const auto* mesh = std::get_if<Mesh>(&shape.geometry)) visit(*mesh, to_world * shape.to_world, visitor);
  if (const auto* deforming = std::get_if<DeformingMesh>(&shape.geometry))
    for (const DeformingMesh::Key& key : deforming->keys)
      if (const auto* mesh = std::get_if<Mesh>(&key.mesh))
        visit(*mesh, to_world * shape.to_world * key.to_shape, visitor);
}

/// Unit vectors all over a hemisphere, by a spiral (Swinbank and Purser 2006).
std::vector<Vec3d> hemisphere_directions(int count) {
  std::vector<Vec3d> directions;
  for (int i = 0; i < count; ++i) {
    const double z = (i + 0.5) / count, r = std::sqrt(1 - z * z), angle = i * std::numbers::pi * (3 - std::sqrt(5.0));
    directions.emplace_back(r * std::cos(angle), r * std::sin(angle), z);
  }
  return directions;
}

/// Vertices of a group that are the farthest ones in some direction, for groups with many instances. Their convex hull
/// is smaller than that of all vertices by about 1 %.
std::vector<Vec3d> extreme_points(const ShapeGroup& group) {
  static const std::vector<Vec3d> directions = hemisphere_directions(128);
  struct Extreme {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    Vec3d lowest, highest;
  };
  std::vector<Extreme> extremes(directions.size());
  const auto add = [&](Vec3d p) {
    for (std::size_t i = 0; i < directions.size(); ++i) {
      const double along = dot(p, directions[i]);
      Extreme& extreme = extremes[i];
      if (along < extreme.low) std::tie(extreme.low, extreme.lowest) = std::pair(along, p);
      if (along > extreme.high) std::tie(extreme.high, extreme.highest) = std::pair(along, p);
    }
  };
  for (const ShapeDescription& shape : group.shapes) visit(shape, Transform(), add);
  std::vector<Vec3d> points;
  for (const Extreme& extreme : extremes)
    if (extreme.low <= extreme.high) points.insert(points.end(), {extreme.lowest, extreme.highest});
  return points;
}

/// Calls the visitor for points of all shapes and instances, whose convex hull is that of the model.
void visit(const Description& description, const PointVisitor& visitor) {
  for (const ShapeDescription& shape : description.shapes) visit(shape, Transform(), visitor);
  std::vector<std::vector<Vec3d>> groups;
  for (const ShapeGroup& group : description.groups) groups.push_back(extreme_points(group));
  for (const InstanceDescription& instance : description.instances) {
    Matrix4 m;
    for (std::size_t i = 0; i < 12; ++i) m.m[i / 4][i % 4] = instance.to_world[i];
    const Transform to_world(m);
    for (const Vec3d p : groups[instance.group]) visitor(to_world.precise_point(p));
  }
}

/// The axes of the view. Azimuths 0 and 90 degrees are +y and +z for the up axis x, +z and +x for y, -y and +x for z.
/// From below, the floor turns with the camera: it is never between camera and model.
void set_axes(const ModelView& view, ModelFrame& frame) {
  const auto radians = [](float degrees) { return double{degrees} * std::numbers::pi / 180; };
  const double c = std::cos(radians(view.elevation)), s = std::sin(radians(view.elevation));
  const double along = std::cos(radians(view.azimuth)), across = std::sin(radians(view.azimuth));
  const bool is_x = view.up == ModelView::Up::kX, is_y = view.up == ModelView::Up::kY;
  const Vec3d up = is_x ? Vec3d{1, 0, 0} : is_y ? Vec3d{0, 1, 0} : Vec3d{0, 0, 1};
  const Vec3d level = is_x ? Vec3d{0, along, across} : is_y ? Vec3d{across, 0, along} : Vec3d{across, -along, 0};
  frame.front = level * c + up * s;
  frame.up = up * c - level * s;
  frame.right = cross(frame.up, frame.front);
  frame.floor_normal = view.elevation < 0 ? frame.up : up;
}

/// Extents of the model along the axes of the frustum, relative to its center.
struct FrustumExtents {
  std::array<double, 4> sides{};  ///< of x - k z, -x - k z, y - k z and -y - k z, with z along the view
  double nearest = 0, squared_radius = 0, bottom = 0;
};

FrustumExtents measure(const Description& description, const ModelFrame& frame, const std::array<double, 2>& k) {
  const Vec3d x = frame.right, y = frame.up, z = -frame.front;
  const std::array<Vec3d, 4> sides{x - z * k[0], -x - z * k[0], y - z * k[1], -y - z * k[1]};
  constexpr double kNone = -std::numeric_limits<double>::infinity();
  FrustumExtents extents{{kNone, kNone, kNone, kNone}, kNone, 0, -kNone};
  visit(description, [&](Vec3d p) {
    if (!is_finite(p)) return;
    const Vec3d from_center = p - frame.center;
    for (std::size_t i = 0; i < 4; ++i) extents.sides[i] = std::max(extents.sides[i], dot(from_center, sides[i]));
    extents.nearest = std::max(extents.nearest, -dot(from_center, z));
    extents.bottom = std::min(extents.bottom, dot(from_center, frame.floor_normal));
    extents.squared_radius = std::max(extents.squared_radius, dot(from_center, from_center));
  });
  return extents.nearest == kNone ? FrustumExtents() : extents;
}

/// Position of the eye relative to the center, for a narrowed frustum with the tangents `k`.
Vec3d place_eye(const FrustumExtents& extents, const ModelFrame& frame, const std::array<double, 2>& k) {
  const std::array<double, 4>& s = extents.sides;
  double x = (s[0] - s[1]) / 2, y = (s[2] - s[3]) / 2;
  const auto distance = [&] {
    const double closest = extents.nearest + kClearance * frame.radius;
    return std::max({(s[0] - x) / k[0], (s[1] + x) / k[0], (s[2] - y) / k[1], (s[3] + y) / k[1], closest});
  };
  const auto eye = [&] { return frame.right * x + frame.up * y + frame.front * distance(); };
  // Stay above the floor
  const double missing = extents.bottom - dot(eye(), frame.floor_normal);
  if (missing > 0) y += missing / std::max(dot(frame.up, frame.floor_normal), 0.1);
  return eye();
}

}  // namespace

ModelFrame frame_model(const std::array<Vec3d, 2>& box, const ModelView& view, Description& description) {
  ModelFrame frame;
  frame.center = box[0] * 0.5 + box[1] * 0.5;
  set_axes(view, frame);
  const double tangent = std::tan(double{view.fov} * std::numbers::pi / 360), aspect = view.aspect_ratio;
  frame.tangents = {tangent * std::max(aspect, 1.0), tangent * std::max(1 / aspect, 1.0)};
  const std::array<double, 2> narrowed{frame.tangents[0] * kFill, frame.tangents[1] * kFill};
  const FrustumExtents extents = measure(description, frame, narrowed);
  frame.radius = std::max(std::sqrt(extents.squared_radius), 1e-6);
  frame.bottom = extents.bottom;
  frame.eye = frame.center + place_eye(extents, frame, narrowed);
  // Set the camera
  CameraDescription& camera = description.camera;
  camera = CameraDescription();
  camera.fov = view.fov;
  camera.fov_axis = CameraDescription::FovAxis::kSmaller;
  const double distance = std::max(dot(frame.eye - frame.center, frame.front), frame.radius);
  camera.to_world = Transform::look_at(frame.eye, frame.eye - frame.front * distance, frame.up);
  camera.near_clip = static_cast<float>(distance * 1e-4);
  camera.far_clip = static_cast<float>(distance * 1e4);
  return frame;
}

}  // namespace sheaf
