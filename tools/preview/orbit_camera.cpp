#include "tools/preview/orbit_camera.h"

#include "scene/description/field_of_view.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sheaf {

namespace {

using Projection = CameraDescription::Projection;

constexpr double kPi64 = std::numbers::pi;
/// Turn by a motion over the height of the image, and the least angle between the view and the vertical, radians.
constexpr double kTurn = kPi64, kPole = 0.02;
constexpr double kMinDistance = 1e-6, kMaxDistance = 1e12;

Vec3d normalized(Vec3d v) { return v * (1 / length(v)); }

/// The vertical of the world: the axis on which the camera stands without roll, or else that of the image.
Vec3d vertical_of(Vec3d x, Vec3d y) {
  Vec3d best = y;
  double most = 0;
  for (const Vec3d axis : {Vec3d(0, 1, 0), Vec3d(0, 0, 1), Vec3d(1, 0, 0)}) {
    const double upright = dot(axis, y);
    if (std::abs(dot(axis, x)) > 1e-4 || std::abs(upright) <= most + 1e-9) continue;
    most = std::abs(upright);
    best = upright > 0 ? axis : -axis;
  }
  return best;
}

}  // namespace

bool is_movable(const Description& scene) {
  const Projection projection = scene.camera.projection;
  return scene.more_cameras.empty() &&
         (projection == Projection::kPerspective || projection == Projection::kOrthographic ||
          projection == Projection::kSpherical);
}

OrbitCamera::OrbitCamera(const CameraDescription& camera, const FilmSettings& film, double distance)
    : camera_(camera), aspect_(static_cast<double>(film.height) / film.width), origin_(camera.to_world.translation()) {
  const Vec3d forward = normalized(Vec3d(camera.to_world.vector({0, 0, 1})));
  const Vec3d y = normalized(Vec3d(camera.to_world.vector({0, 1, 0})));
  target_ = origin_ + forward * std::clamp(distance, kMinDistance, kMaxDistance);
  const Transform upright = Transform::look_at(origin_, target_, y);
  up_ = vertical_of(Vec3d(upright.vector({1, 0, 0})), Vec3d(upright.vector({0, 1, 0})));
  local_ = frame().inverse() * camera.to_world;
}

double OrbitCamera::height() const {
  const Vec3d s = scale();
  if (camera_.projection == Projection::kOrthographic) return 2 * aspect_ * std::abs(s.y);
  if (camera_.projection == Projection::kSpherical) return kPi64 * distance();
  const double half = half_width_of(camera_.fov, camera_.fov_axis, 1, aspect_, camera_.where);
  return 2 * half * aspect_ * distance() * std::abs(s.y / s.z);
}

Vec3d OrbitCamera::scale() const {
  const auto length_of = [&](Vec3f axis) { return length(Vec3d(local_.vector(axis))); };
  const double sign = local_.swaps_handedness() ? -1 : 1;
  return {sign * length_of({1, 0, 0}), length_of({0, 1, 0}), length_of({0, 0, 1})};
}

void OrbitCamera::orbit(double x, double y) {
  const Vec3d view = target_ - origin_;
  // Angle between the view and the vertical, which stays away from the poles
  const double angle = std::acos(std::clamp(dot(normalized(view), up_), -1.0, 1.0));
  const double turned = std::clamp(angle + kTurn * y, std::min(angle, kPole), std::max(angle, kPi64 - kPole));
  const double degrees = 180 / kPi64;
  const bool mirrored = local_.swaps_handedness();
  const Transform tilt = Transform::rotate(axis({1, 0, 0}), (turned - angle) * degrees);
  const Transform turn = Transform::rotate(up_, (mirrored ? kTurn : -kTurn) * x * degrees);
  origin_ = target_ - (turn * tilt).precise_point(view);
}

void OrbitCamera::pan(double x, double y) {
  const double side = local_.swaps_handedness() ? -1 : 1;  // camera space has +x to the left
  const Vec3d by = (axis({1, 0, 0}) * (side * x) + axis({0, 1, 0}) * y) * height();
  origin_ = origin_ + by;
  target_ = target_ + by;
}

void OrbitCamera::dolly(double steps) {
  const double factor = std::exp2(steps);
  if (camera_.projection == Projection::kOrthographic) {
    local_ = local_ * Transform::scale({factor, factor, 1});
    return;
  }
  const Vec3d view = target_ - origin_;
  const double moved = std::clamp(length(view) * factor, kMinDistance, kMaxDistance);
  origin_ = target_ - normalized(view) * moved;
}

void OrbitCamera::look_at(Vec3d point) {
  const Vec3d view = point - origin_;
  if (!(length(view) > kMinDistance)) return;
  // No camera stands on its head
  if (std::abs(dot(normalized(view), up_)) < std::cos(kPole)) target_ = point;
}

void OrbitCamera::focus(Vec3d point) {
  const Vec3d forward = Vec3d(camera().to_world.vector({0, 0, 1}));
  const double z = dot(point - origin_, forward) / dot(forward, forward);
  if (!(z > 0)) return;
  camera_.focus_distance = static_cast<float>(z);
  has_focus_ = true;
}

CameraDescription OrbitCamera::camera() const {
  CameraDescription moved = camera_;
  moved.to_world = frame() * local_;
  moved.motion.reset();
  moved.medium.reset();
  return moved;
}

std::string OrbitCamera::text(Vec3d point) const {
  const double step = std::pow(10, std::floor(std::log10(std::max(distance(), kMinDistance))) - 5);
  const auto rounded = [&](double v) { return std::round(v / step) * step + 0.0; };
  return fmt::format("{:.12g}, {:.12g}, {:.12g}", rounded(point.x), rounded(point.y), rounded(point.z));
}

std::string OrbitCamera::mitsuba_text() const {
  const Vec3d s = scale(), up = up_;
  std::string out = "<transform name=\"to_world\">\n";
  const bool is_scaled = std::max({std::abs(s.x - 1), std::abs(s.y - 1), std::abs(s.z - 1)}) > 1e-5;
  if (is_scaled) out += fmt::format("  <scale x=\"{:.6g}\" y=\"{:.6g}\" z=\"{:.6g}\"/>\n", s.x, s.y, s.z);
  out += fmt::format("  <lookat origin=\"{}\" target=\"{}\" up=\"{:.6g}, {:.6g}, {:.6g}\"/>\n</transform>",
                     text(origin_), text(target_), up.x, up.y, up.z);
  if (has_focus_) out += fmt::format("\n<float name=\"focus_distance\" value=\"{:.6g}\"/>", camera_.focus_distance);
  return out;
}

std::string OrbitCamera::pbrt_text() const {
  // pbrt's camera space has +x to the right
  const Vec3d s = scale();
  const bool is_scaled = std::max({std::abs(s.x + 1), std::abs(s.y - 1), std::abs(s.z - 1)}) > 1e-5;
  std::string out;
  if (is_scaled) out = fmt::format("Scale {:.6g} {:.6g} {:.6g}\n", -1 / s.x, 1 / s.y, 1 / s.z);
  std::string numbers = fmt::format("{} {} {:.6g} {:.6g} {:.6g}", text(origin_), text(target_), up_.x, up_.y, up_.z);
  std::erase(numbers, ',');
  out += "LookAt " + numbers;
  if (has_focus_) out += fmt::format("\n# focaldistance: {:.6g}", camera_.focus_distance);
  return out;
}

}  // namespace sheaf
