// Live web page of a running render: its content, and the server that delivers it.
#pragma once

#include "core/image/display_transform.h"
#include "core/image/image.h"
#include "kernels/render/render_progress.h"
#include "tools/preview/camera_control.h"
#include "tools/preview/http_server.h"
#include "tools/preview/preview_denoiser.h"

#include <atomic>
#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>

namespace sheaf {

/// Answers GET requests for "/" (the page, which is self-contained), "/status.json" and "/image.png". Requests for
/// "/denoised/status.json" also switch on denoising for a few seconds; "/denoised/image.png" is the result. With a
/// CameraControl, POST requests for "/camera" move the camera, and GET requests for "/pick.json" name what a pixel
/// shows. All functions are thread-safe.
class LivePage {
 public:
  /// Starts the server. `display`: applied to images unless the browser requests another one. `repeats`: other renders
  /// follow. `camera`: null if it cannot be moved. Throws Error (exit code 1) on failure.
  LivePage(const Endpoint& endpoint, std::string scene, DisplayTransform display, bool repeats, CameraControl* camera);
  /// Closes all connections.
  ~LivePage() = default;

  const std::string& url() const { return server_.url(); }

  /// Begins to read the scene of another render. The last image remains until there is a new one.
  void begin_scene();
  /// Starts the clock of the render.
  void begin_render();
  /// Begins another render of the same scene, with a camera that moves.
  void begin_move();
  /// Sets how browsers show the image, unless they choose another exposure or tone map.
  void set_display(const DisplayTransform& display);
  /// Sets the progress, as RenderControl::on_progress. Cheap.
  void update(const RenderProgress& progress);
  /// Sets the state of the render: "reading", "rendering", "writing", "done" ...
  void set_state(const std::string& state);
  /// Sets the state "failed", and shows the errors where the image is.
  void fail(const std::string& errors);
  /// Sets the statistics so far, a JSON object.
  void set_report(const std::string& json);
  /// Sets the image so far, with linear colors; it is encoded on request. `layers`: further layers of the same view, at
  /// the same or another resolution; null: the last ones remain.
  void set_image(std::shared_ptr<const Image> image, std::shared_ptr<const Image> layers = nullptr);
  /// Denoises the last image of set_image(), given with its layers, and shows the result when it is ready.
  void denoise(std::shared_ptr<const Image> image, bool has_variances);
  /// Adds a line to the log. The page shows the last 200 lines.
  void add_message(std::string_view message);

  /// Whether a browser is connected and has requested the last image.
  bool wants_image() const;
  /// Whether a browser is connected that shows denoised images.
  bool wants_denoised() const;
  /// Time that encoding the last image took, s.
  double encoding_seconds() const { return encoding_seconds_.load(std::memory_order_relaxed); }
  /// If a browser is connected, waits until it has received the last state and image, at most `seconds`.
  void wait_until_seen(double seconds);

 private:
  /// An image as PNG file for a browser.
  struct EncodedView {
    int number = 0;      ///< of the image
    std::string source;  ///< "", "denoised" or the name of a layer
    std::string display;
    std::shared_ptr<const std::string> png;
  };

  HttpResponse answer(const HttpRequest& request);
  RenderProgress progress() const;
  void set_progress(const RenderProgress& progress);
  HttpResponse status();
  HttpResponse encoded_image(const HttpRequest& request, const std::string& source);
  HttpResponse move(const HttpRequest& request) const;
  HttpResponse picked(const HttpRequest& request) const;
  std::shared_ptr<const Image> source_image(const std::string& source, int& number) const;
  std::shared_ptr<const std::string> encoded(const std::shared_ptr<const Image>& image, EncodedView view);
  std::shared_ptr<const std::string> sent_body(const std::shared_ptr<const std::string>& png, int number);
  bool is_watched() const;

  const std::string scene_;  ///< the file
  const bool repeats_;
  CameraControl* const camera_;  ///< null: it cannot be moved
  mutable std::mutex progress_mutex_;
  RenderProgress progress_;                    ///< guarded by progress_mutex_
  std::atomic<double> looked_{-1e9};           ///< time of the last status request, s on the steady clock
  std::atomic<double> denoised_looked_{-1e9};  ///< the same for denoised images
  std::atomic<double> encoding_seconds_{0};
  std::atomic<bool> image_seen_{true};       ///< the last image was requested; true if there is no image
  std::atomic<bool> image_denoised_{false};  ///< the last image is denoised
  mutable std::mutex mutex_;                 ///< guards the members below
  std::condition_variable seen_;
  DisplayTransform display_;
  std::string run_;  ///< an id that distinguishes this render from others at the same port
  std::string state_ = "reading", report_ = "null", errors_;
  bool state_seen_ = false;
  double start_ = 0, end_ = 0;  ///< of the render, s on the steady clock; 0: not yet
  std::deque<std::string> messages_;
  std::shared_ptr<const Image> image_, layers_, denoised_;  ///< linear; null: none
  int image_number_ = 0, layers_number_ = 0,
      sent_number_ = 0;              ///< of the last images, and of the last one sent; 0: none
  int denoised_number_ = 0;          ///< number of the denoised image; 0: none
  std::deque<EncodedView> encoded_;  ///< the last few; only for the server's thread
  // The threads of the last members use the others and must end first
  PreviewDenoiser denoiser_;
  HttpServer server_;
};

}  // namespace sheaf
