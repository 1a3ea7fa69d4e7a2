#include "tools/cli/moving_frames.h"

#include "scene/compile/move_camera.h"
#include "tools/console/messages.h"
#include "tools/console/progress.h"
#include "tools/preview/camera_control.h"
#include "tools/preview/displayed_layer.h"
#include "tools/preview/preview.h"

#include <algorithm>
#include <cmath>

namespace sheaf {

namespace {

/// Time without a motion after which the camera rests, s.
constexpr double kRestSeconds = 0.25;

/// Places the camera; `camera` does not trace rays meanwhile. Returns false for cameras that cannot be rendered.
bool place(const CameraDescription& description, const FilmSettings& film, const PixelRect& crop, LoadedScene& loaded,
           CameraControl& camera) {
  camera.detach();
  bool is_placed = true;
  try {
    move_camera(description, film, loaded.scene);
    loaded.description.camera = description;
  } catch (const SceneError& error) {
    print_message(error.what());
    is_placed = false;
  }
  if (is_placed) camera.attach(*loaded.scene, crop);
  return is_placed;
}

}  // namespace

double next_frame_pixels(double pixels, double seconds, double max_pixels) {
  constexpr double kMinPixels = 2000, kGrowth = 2, kShrink = 0.25;
  const double change = std::clamp(kFrameSeconds / std::max(seconds, 1e-6), kShrink, kGrowth);
  return std::clamp(pixels * change, std::min(kMinPixels, max_pixels), max_pixels);
}

RenderSettings frame_settings(const RenderSettings& settings, double pixels) {
  const double scale = std::min(1.0, std::sqrt(pixels / static_cast<double>(settings.crop.area())));
  const auto scaled = [&](int side) { return std::max(1, static_cast<int>(std::lround(side * scale))); };
  SceneSettings small = settings;
  small.film.width = scaled(settings.film.width);
  small.film.height = scaled(settings.film.height);
  small.film.crop.reset();
  RenderRequest request;
  request.samples_per_pixel = 1;
  request.replicates = 1;
  request.aovs = page_layers(settings.integrator);
  const PixelRect& crop = settings.crop;
  const PixelRect window{std::min(static_cast<int>(crop.x0 * scale), small.film.width - 1),
                         std::min(static_cast<int>(crop.y0 * scale), small.film.height - 1),
                         std::min(scaled(crop.x1), small.film.width), std::min(scaled(crop.y1), small.film.height)};
  request.crop =
      PixelRect{window.x0, window.y0, std::max(window.x1, window.x0 + 1), std::max(window.y1, window.y0 + 1)};
  return resolve_settings(small, settings.color, request);
}

void MovingFrames::follow(LoadedScene& loaded, const RenderControl& control, CameraControl& camera, Preview& preview) {
  const auto max_pixels = static_cast<double>(loaded.settings.crop.area());
  preview.begin_move();
  // The first frame has waited until the render stopped
  pixels_ *= 0.35;
  double wait = 0;
  while (const auto moved = camera.take(wait)) {
    wait = kRestSeconds;
    const double start = Progress::steady_seconds();
    const RenderSettings settings = frame_settings(loaded.settings, pixels_);
    if (!place(*moved, settings.film, settings.crop, loaded, camera)) continue;
    preview.show_move(render(*loaded.scene, settings, control));
    const auto used = static_cast<double>(settings.crop.area());
    pixels_ = next_frame_pixels(used, Progress::steady_seconds() - start, max_pixels);
  }
  place(loaded.description.camera, loaded.settings.film, loaded.settings.crop, loaded, camera);
}

}  // namespace sheaf
