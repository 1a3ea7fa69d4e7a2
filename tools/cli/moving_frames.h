// Small, fast renders that follow a camera while a hand moves it.
#pragma once

#include "tools/job/render_job.h"

namespace sheaf {

class CameraControl;
class Preview;

/// Keeps the resolution at which a frame answers in time on this machine.
class MovingFrames {
 public:
  /// Renders frames until the camera has rested for a moment. `loaded` is compiled; afterwards, its scene and its
  /// description have the camera in its last place. Frames with invalid cameras are skipped.
  void follow(LoadedScene& loaded, const RenderControl& control, CameraControl& camera, Preview& preview);

 private:
  double pixels_ = 20'000;  ///< of a frame
};

/// Time of a frame that leaves enough of 100 ms for its way to the browser, s.
inline constexpr double kFrameSeconds = 0.055;

/// The number of pixels for the next frame, after one with `pixels` took `seconds`: at most `max_pixels`.
double next_frame_pixels(double pixels, double seconds, double max_pixels);

/// The settings of a frame of about this many pixels, with one sample per pixel and the layers that pages show.
RenderSettings frame_settings(const RenderSettings& settings, double pixels);

}  // namespace sheaf
