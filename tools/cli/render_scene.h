// One render, from reading the scene to writing the images.
#pragma once

#include "scene/compile/geometry/kept_geometry.h"
#include "tools/cli/moving_frames.h"
#include "tools/job/render_arguments.h"
#include "tools/preview/camera_control.h"
#include "tools/preview/preview.h"

#include <filesystem>
#include <functional>
#include <vector>

namespace sheaf {

class FrameRun;

/// A render that is repeated when its scene changes or its camera is moved. It writes no images unless the user named
/// them, and none of a moved camera.
struct RepeatedRender {
  Preview& preview;                          ///< also shows the renders before and after this one
  CameraControl& camera;                     ///< moves the camera of the scene
  std::vector<std::filesystem::path> files;  ///< receives the files of the scene
  /// Waits until the scene has changed, or the camera has moved: true.
  std::function<bool()> wait_for_move = {};
  KeptGeometry geometry = {};  ///< of the render before
  MovingFrames frames = {};
};

/// Renders a scene with the options of `sheaf render`, and `given`, those on the command line. Returns the exit code.
/// Throws Error. `repeated`: null unless the render is repeated. `frames`: the state that the render shares with other
/// frames of an animation; null for a single image.
int render_scene(const RenderArguments& arguments, const std::vector<GivenOption>& given,
                 RepeatedRender* repeated = nullptr, FrameRun* frames = nullptr);

}  // namespace sheaf
