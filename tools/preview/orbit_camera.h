// A camera that a hand turns around a point, and the text that places it in a scene file.
#pragma once

#include "core/math/vec3d.h"
#include "scene/description.h"

#include <string>

namespace sheaf {

/// Whether the camera of a scene can be moved: it forms an image, and there is only one.
bool is_movable(const Description& scene);

/// The camera of a scene, moved as by a hand. Lengths on the screen are fractions of the image's height; x to the
/// right, y down.
class OrbitCamera {
 public:
  /// `distance`: from the camera to the point on its axis around which it turns; positive, in units of the world.
  OrbitCamera(const CameraDescription& camera, const FilmSettings& film, double distance);

  /// Turns around the target so that the objects in front of it follow the hand. Keeps the horizon, and stops at the
  /// poles.
  void orbit(double x, double y);
  /// Moves along the film so that the target follows the hand.
  void pan(double x, double y);
  /// Multiplies the distance from the target, or the size of an orthographic image, by 2^steps.
  void dolly(double steps);
  /// Turns towards a point of the world, which becomes the target.
  void look_at(Vec3d point);
  /// Places the focal plane at a point of the world. Does nothing for points behind the camera.
  void focus(Vec3d point);

  /// The camera in its present place. It does not move during the shutter, and its medium is found by rays.
  CameraDescription camera() const;
  const Vec3d& origin() const { return origin_; }
  const Vec3d& target() const { return target_; }
  const Vec3d& up() const { return up_; }

  /// The elements of a Mitsuba sensor: `<transform name="to_world">` with a lookat, and the focus distance if it was
  /// set.
  std::string mitsuba_text() const;
  /// pbrt's LookAt, after a Scale if the image is mirrored or scaled.
  std::string pbrt_text() const;

 private:
  double distance() const { return length(target_ - origin_); }
  Transform frame() const { return Transform::look_at(origin_, target_, up_); }
  Vec3d axis(Vec3f local) const { return Vec3d(frame().vector(local)); }
  /// Height of the image at the target, units of the world.
  double height() const;
  /// Factors of the axes between this camera's space and a rigid one.
  Vec3d scale() const;
  /// A point to the digits that matter at this distance.
  std::string text(Vec3d point) const;

  CameraDescription camera_;
  double aspect_;  ///< height of the film by its width
  Vec3d origin_, target_, up_;
  Transform local_;  ///< from the camera's space to that of frame(), which is rigid
  bool has_focus_ = false;
};

}  // namespace sheaf
