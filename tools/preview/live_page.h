// Live web page of a running render: its content, and the server that delivers it.
#pragma once

#include "core/image/display_transform.h"
#include "core/image/image.h"
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
/// "/denoised/status.json" also switch on denoising for a few seconds; "/denoised/image.png" is the result. All
/// functions are thread-safe.
class LivePage {
 public:
  /// Starts the server. `display`: applied to denoised images; others are given as displayed. `repeats`: other renders
  /// follow. Throws Error (exit code 1) on failure.
  LivePage(const Endpoint& endpoint, std::string scene, const DisplayTransform& display, bool repeats);
  /// Closes all connections.
  ~LivePage() = default;

  const std::string& url() const { return server_.url(); }

  /// Begins to read the scene of another render. The last image remains until there is a new one.
  void begin_scene();
  /// Starts the clock of the render.
  void begin_render();
  /// Sets the progress, in the units of RenderControl::on_progress. Cheap.
  void update(std::uint64_t done, std::uint64_t total);
  /// Sets the state of the render: "reading", "rendering", "writing", "done" ...
  void set_state(const std::string& state);
  /// Sets the statistics so far, a JSON object.
  void set_report(const std::string& json);
  /// Sets the image so far; it is encoded on the first request.
  void set_image(std::shared_ptr<const Image> image);
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
  HttpResponse answer(std::string_view path);
  HttpResponse status();
  HttpResponse encoded_image();
  HttpResponse denoised_image();
  bool is_watched() const;

  const std::string scene_;  ///< the file
  const bool repeats_;
  std::atomic<std::uint64_t> done_{0}, total_{0};
  std::atomic<double> looked_{-1e9};           ///< time of the last status request, s on the steady clock
  std::atomic<double> denoised_looked_{-1e9};  ///< the same for denoised images
  std::atomic<double> encoding_seconds_{0};
  std::atomic<bool> image_seen_{true};       ///< the last image was requested; true if there is no image
  std::atomic<bool> image_denoised_{false};  ///< the last image is denoised
  mutable std::mutex mutex_;                 ///< guards the members below
  std::condition_variable seen_;
  std::string run_;  ///< an id that distinguishes this render from others at the same port
  std::string state_ = "reading", report_ = "null";
  bool state_seen_ = false;
  double start_ = 0, end_ = 0;  ///< of the render, s on the steady clock; 0: not yet
  std::deque<std::string> messages_;
  std::shared_ptr<const Image> image_;
  std::shared_ptr<const std::string> encoded_;   ///< image_ as a PNG file; null: not encoded yet
  int image_number_ = 0, sent_number_ = 0;       ///< numbers of the last image and of the last image sent; 0: none
  std::shared_ptr<const std::string> denoised_;  ///< a denoised image as a PNG file; null: none
  int denoised_number_ = 0;                      ///< number of that image; 0: none
  // The threads of the last members use the others and must end first
  PreviewDenoiser denoiser_;
  HttpServer server_;
};

}  // namespace sheaf
