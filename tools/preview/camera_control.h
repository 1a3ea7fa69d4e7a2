// The camera of a watched scene between the browsers that move it and the render that follows.
#pragma once

#include "core/image/pixel_rect.h"
#include "scene/scene.h"
#include "tools/preview/camera_request.h"
#include "tools/preview/orbit_camera.h"

#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <string>

namespace sheaf {

/// What lies at a position of the image.
struct PickedPoint {
  std::string object, material;
  Vec3d position;       ///< world space, meters
  double distance = 0;  ///< from the camera, meters; orthographic: from its near plane
};

/// The camera as a page shows it.
struct CameraState {
  bool is_moved = false;      ///< it differs from that of the file
  int number = 0;             ///< grows with each motion
  std::string mitsuba, pbrt;  ///< see OrbitCamera
};

/// Browsers call move(), pick() and state(), the render calls the other functions. All are thread-safe.
class CameraControl {
 public:
  /// `on_move` is called after each motion, on the thread of the browser's request.
  explicit CameraControl(std::function<void()> on_move) : on_move_(std::move(on_move)) {}

  /// Applies a motion, also between two scenes. Returns false if no camera can be moved.
  bool move(const CameraRequest& request);
  /// The nearest surface at a position. Empty if the ray misses the scene, or while no scene is attached.
  std::optional<PickedPoint> pick(ImagePosition position) const;
  /// Empty if no camera can be moved.
  std::optional<CameraState> state() const;

  /// Begins with another scene. The camera stays where it was moved unless the camera of the file has changed. Returns
  /// that camera if it is moved.
  std::optional<CameraDescription> begin_scene(const Description& scene, const FilmSettings& film);
  /// Allows rays through the scene until detach(). `crop`: the pixels of its film that browsers show.
  void attach(const Scene& scene, const PixelRect& crop);
  void detach();
  /// Whether take() would return a camera at once.
  bool has_moved() const;
  /// Waits for a motion, at most `seconds`. Returns has_moved().
  bool wait(double seconds);
  /// Waits for a motion, at most `seconds`. Returns the camera in its place: that of the file after a reset.
  std::optional<CameraDescription> take(double seconds);
  /// Whether the camera of the last take() is that of the file.
  bool is_at_home() const;

 private:
  std::optional<PickedPoint> trace(ImagePosition position) const;

  const std::function<void()> on_move_;
  mutable std::mutex mutex_;  ///< guards the members below
  std::condition_variable moved_;
  std::optional<CameraDescription> file_;  ///< of the scene file; empty: it cannot be moved
  FilmSettings film_;
  std::optional<OrbitCamera> camera_;  ///< empty until the scene is attached
  double distance_ = 1;                ///< from the camera of the file to its target
  const Scene* scene_ = nullptr;
  PixelRect crop_;
  bool is_moved_ = false, was_moved_ = false;  ///< at present, and at the last take()
  int number_ = 0, taken_ = 0;
};

}  // namespace sheaf
