// Live previews of a running render: in the image viewer tev, and as a web page.
#pragma once

#include "core/image/display_transform.h"
#include "kernels/passes/render_report.h"
#include "tools/options/options.h"

#include <atomic>
#include <memory>
#include <string>

namespace sheaf {

class CameraControl;
class LivePage;
class Scene;
class TevViewer;
struct RenderControl;
struct RenderResult;
struct RenderSettings;
struct RenderState;

/// Command-line options for previews.
struct PreviewArguments {
  std::string tev;    ///< HOST:PORT; empty: disabled
  std::string serve;  ///< PORT or ADDRESS:PORT; empty: disabled
};

void add_preview_options(Command& command, PreviewArguments& arguments);

/// Shows one render, or several one after the other, from construction to destruction, which closes all connections.
///
/// Preview images are made while the render pauses, and only for connected viewers: at
/// most one per second. Slow previews are refreshed less often, so that they take at most 5% of the time.
/// They do not change the bits of the render.
class Preview {
 public:
  /// Starts the server and the search for the viewer, as requested. `name`: of the image.
  /// `display`: applied to the images. Throws Error: exit code 2 for
  /// malformed addresses, 1 for unknown hosts and if it cannot listen.
  /// `repeats`: another render may follow a finished one. `camera`: of a page that moves it; null: it does not.
  Preview(const PreviewArguments& arguments, const std::string& scene, const std::string& name,
          DisplayTransform display, bool repeats = false, CameraControl* camera = nullptr);
  ~Preview();
  Preview(const Preview&) = delete;
  Preview& operator=(const Preview&) = delete;

  /// Replaces the display.
  void set_display(DisplayTransform display);
  /// Begins to read a scene, after another render.
  void begin_scene();
  /// Begins fast renders of the same scene with a camera that moves.
  void begin_move();
  /// Shows such a render.
  void show_move(const RenderResult& result);
  /// Begins the render. Wraps the callbacks of `control`, which must not outlive this object.
  void watch(RenderControl& control);
  /// Shows renders with 1, 2 and 4 samples per pixel, and with 8 and 16 if another render may follow, while they take
  /// little of the time of the render with these settings. Until that render has samples of a pixel, previews show the
  /// last of these images there. Does nothing for resumed renders and for integrators other than path tracing.
  void show_first_passes(const Scene& scene, const RenderSettings& settings, const RenderControl& control);
  /// Marks the end of rendering, before the outputs are written.
  void begin_writing();
  /// Reports that the scene could not be rendered. `errors`: a line for each.
  void fail(const std::string& errors);
  /// Shows the finished image. Waits for viewers to fetch it if no render follows: at most 5 s for tev, 3 s for
  /// browsers, and not at all if nobody is connected. `state`: "done", "interrupted" ...
  void finish(const std::string& state, const Image& image, const RenderReport& report);

 private:
  bool is_due();
  void show(const RenderState& state);
  std::shared_ptr<const Image> displayed(const Image& image) const;

  const bool repeats_;
  DisplayTransform display_;
  std::unique_ptr<LivePage> page_;          ///< null: disabled
  std::unique_ptr<TevViewer> tev_;          ///< null: disabled
  std::shared_ptr<const Image> first_;      ///< of show_first_passes(); may be null
  std::atomic<double> next_{0};             ///< earliest time of the next preview, s on the steady clock
  std::atomic<double> pause_requested_{0};  ///< time of the last request to pause for a preview; 0: none
};

}  // namespace sheaf
