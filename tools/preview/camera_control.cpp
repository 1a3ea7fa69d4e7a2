#include "tools/preview/camera_control.h"

#include "scene/accel/accel.h"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace sheaf {

namespace {

/// Whether two descriptions of cameras give the same image.
bool is_same_camera(const CameraDescription& a, const CameraDescription& b) {
  return a.projection == b.projection && a.to_world.matrix().m == b.to_world.matrix().m && a.fov == b.fov &&
         a.fov_axis == b.fov_axis && a.aperture_radius == b.aperture_radius && a.focus_distance == b.focus_distance &&
         a.principal_point_x == b.principal_point_x && a.principal_point_y == b.principal_point_y &&
         a.near_clip == b.near_clip && a.far_clip == b.far_clip && a.distortion == b.distortion &&
         a.equal_area == b.equal_area;
}

/// The distance from the camera to what it shows: to the surface in the middle, or else to the middle of the scene.
double distance_of(const CameraDescription& camera, const Scene& scene, const std::optional<PickedPoint>& middle) {
  const Vec3d origin = camera.to_world.translation(), forward(normalize(camera.to_world.vector({0, 0, 1})));
  if (middle) return dot(middle->position - origin, forward);
  const Vec3d center = Vec3d(scene.view().center) + scene.origin();
  const auto radius = static_cast<double>(scene.view().radius);
  return std::max(dot(center - origin, forward), 0.1 * radius);
}

}  // namespace

bool CameraControl::move(const CameraRequest& request) {
  {
    const std::lock_guard lock(mutex_);
    if (!camera_) return false;
    const bool turns = request.orbit[0] != 0 || request.orbit[1] != 0,
               pans = request.pan[0] != 0 || request.pan[1] != 0;
    if (request.reset) camera_.emplace(*file_, film_, distance_);
    if (turns) camera_->orbit(request.orbit[0], request.orbit[1]);
    if (pans) camera_->pan(request.pan[0], request.pan[1]);
    if (request.dolly != 0) camera_->dolly(request.dolly);
    const std::optional<PickedPoint> target = request.target ? trace(*request.target) : std::nullopt;
    const std::optional<PickedPoint> focus = request.focus ? trace(*request.focus) : std::nullopt;
    if (target) camera_->look_at(target->position);
    if (focus) camera_->focus(focus->position);
    const bool moves = turns || pans || request.dolly != 0 || target || focus;
    if (!moves && !request.reset) return true;
    is_moved_ = moves;
    ++number_;
  }
  moved_.notify_all();
  on_move_();
  return true;
}

std::optional<PickedPoint> CameraControl::pick(ImagePosition position) const {
  const std::lock_guard lock(mutex_);
  return trace(position);
}

std::optional<PickedPoint> CameraControl::trace(ImagePosition position) const {
  if (scene_ == nullptr) return std::nullopt;
  // Trace a ray through the center of the lens
  const SceneView& view = scene_->view();
  const auto x = static_cast<float>(crop_.x0 + position.x * crop_.width());
  const auto y = static_cast<float>(crop_.y0 + position.y * crop_.height());
  const CameraRay<Scalar> ray = view.sensor.camera.ray<Scalar>(x, y, 0, 0);
  RayPacket packet;
  for (int i = 0; i < kPacketWidth; ++i) packet.set_ray(i, ray.origin, ray.direction, ray.t_max);
  view.accel->intersect(packet, 1);
  const std::uint32_t shape = packet.shape[0];
  if (shape == kNone) return std::nullopt;
  // Name what it hits
  PickedPoint point;
  point.distance = static_cast<double>(packet.t_far[0]);
  point.position = Vec3d(ray.origin) + scene_->origin() + Vec3d(ray.direction) * point.distance;
  // Rays start at the near plane
  const Camera& camera = view.sensor.camera;
  if (camera.origin_dx == Vec3f{0, 0, 0}) point.distance = length(point.position - scene_->origin() - camera.origin);
  const SceneNames& names = scene_->names();
  if (shape < names.object_of_shape.size()) {
    point.object = names.objects[names.object_of_shape[shape]];
    point.material = names.materials[names.material_of_shape[shape]];
  }
  return point;
}

std::optional<CameraState> CameraControl::state() const {
  const std::lock_guard lock(mutex_);
  if (!camera_) return std::nullopt;
  return CameraState{is_moved_, number_, camera_->mitsuba_text(), camera_->pbrt_text()};
}

std::optional<CameraDescription> CameraControl::begin_scene(const Description& scene, const FilmSettings& film) {
  const std::lock_guard lock(mutex_);
  scene_ = nullptr;
  film_ = film;
  const bool stays = is_moved_ && file_ && is_movable(scene) && is_same_camera(*file_, scene.camera);
  if (!stays) {
    camera_.reset();
    is_moved_ = false;
    taken_ = number_;
  }
  file_.reset();
  if (is_movable(scene)) file_ = scene.camera;
  was_moved_ = is_moved_;
  if (!stays) return std::nullopt;
  taken_ = number_;
  return camera_->camera();
}

void CameraControl::attach(const Scene& scene, const PixelRect& crop) {
  const std::lock_guard lock(mutex_);
  scene_ = &scene;
  crop_ = crop;
  if (camera_ || !file_) return;
  distance_ = distance_of(*file_, scene, trace({0.5, 0.5}));
  camera_.emplace(*file_, film_, distance_);
}

void CameraControl::detach() {
  const std::lock_guard lock(mutex_);
  scene_ = nullptr;
}

bool CameraControl::has_moved() const {
  const std::lock_guard lock(mutex_);
  return number_ != taken_;
}

bool CameraControl::wait(double seconds) {
  std::unique_lock lock(mutex_);
  return moved_.wait_for(lock, std::chrono::duration<double>(seconds), [this] { return number_ != taken_; });
}

std::optional<CameraDescription> CameraControl::take(double seconds) {
  if (!wait(seconds)) return std::nullopt;
  const std::lock_guard lock(mutex_);
  taken_ = number_;
  was_moved_ = is_moved_;
  return is_moved_ ? camera_->camera() : *file_;
}

bool CameraControl::is_at_home() const {
  const std::lock_guard lock(mutex_);
  return !was_moved_;
}

}  // namespace sheaf
