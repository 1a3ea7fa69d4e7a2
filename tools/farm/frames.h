// Animations: the frames that `sheaf render` renders one after the other, and their common state.
#pragma once

#include "core/io/file_cache.h"
#include "scene/compile/geometry/kept_geometry.h"
#include "tools/farm/frame_names.h"
#include "tools/job/render_arguments.h"

#include <filesystem>
#include <functional>
#include <set>
#include <string>
#include <vector>

namespace sheaf {

/// The frames of one run of `sheaf render`, and their common state.
class FrameRun {
 public:
  explicit FrameRun(std::size_t count) : count_(count) {}

  void begin_frame(int frame);
  /// "frame 7 (3 of 48)"
  std::string label() const;
  /// Whether this note or warning was not given for an earlier frame.
  bool is_new(const std::string& message) { return given_.insert(message).second; }

  KeptGeometry geometry;

 private:
  FileCache files_;
  std::set<std::string> given_;
  std::size_t count_, position_ = 0;
  int frame_ = 0;
};

/// Callbacks of a run of frames.
struct FrameCalls {
  /// Checks the outputs of a frame as before a render. Throws Error.
  std::function<void(const RenderArguments& arguments)> check;
  /// Renders a frame. Returns its exit code.
  std::function<int(const RenderArguments& arguments, const std::vector<GivenOption>& given, FrameRun& run)> render;
};

/// Frames per second of glTF files by default.
inline constexpr float kDefaultFrameRate = 24;

/// Throws Error (exit code 2) if --frames does not apply to the scene file: a model that does not move.
void check_has_frames(const std::filesystem::path& scene);

/// Throws Error (exit code 2) for options that exclude --frames, or need it.
void check_frame_options(const RenderArguments& arguments);

/// Renders the frames of --frames one after the other until one fails or is interrupted. `given`: the options on the
/// command line. Returns the exit code of the last frame. Throws Error as renders do.
int render_frames(const RenderArguments& arguments, const std::vector<GivenOption>& given, const FrameCalls& calls);

}  // namespace sheaf
