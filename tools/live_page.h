// A page for browsers that shows a render while it runs: what is told of it, and the server that tells it.
#pragma once

#include "core/image.h"
#include "tools/http_server.h"

#include <atomic>
#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>

namespace sheaf {

/// Answers GET requests for "/" (the page, which needs nothing else), "/status.json" and "/picture.png". All functions
/// may be called by any thread.
class LivePage {
 public:
  /// Begins to serve. Throws Error (exit code 1) if it cannot.
  LivePage(const Endpoint& endpoint, std::string scene);
  /// Ends all connections.
  ~LivePage() = default;

  const std::string& url() const { return server_.url(); }

  /// Time starts now.
  void begin_render();
  /// How much is done of how much, as RenderOptions::on_progress has it. Cheap.
  void update(std::uint64_t done, std::uint64_t total);
  /// What the render is at: "reading", "rendering", "writing", "done" ...
  void set_state(const std::string& state);
  /// The statistics so far, a JSON object.
  void set_report(const std::string& json);
  /// The picture so far; it is encoded when somebody asks for it.
  void set_picture(std::shared_ptr<const Image> picture);
  /// Adds a line to the log, of which the last 200 are told.
  void add_message(std::string_view message);

  /// Whether a browser looks, and has asked for the last picture.
  bool wants_picture() const;
  /// How long the last picture took to encode.
  double encoding_seconds() const { return encoding_seconds_.load(std::memory_order_relaxed); }
  /// If a browser looks: waits until it has the last state and picture, but no longer than this.
  void wait_until_seen(double seconds);

 private:
  HttpResponse answer(std::string_view path);
  HttpResponse status();
  HttpResponse picture();
  bool is_watched() const;

  const std::string scene_, run_;  ///< the scene file; what tells this render from others at the same port
  std::atomic<std::uint64_t> done_{0}, total_{0};
  std::atomic<double> looked_{-1e9};  ///< when somebody last asked for the status, on the steady clock
  std::atomic<double> encoding_seconds_{0};
  std::atomic<bool> picture_seen_{true};  ///< somebody asked for the last one; true where there is none
  mutable std::mutex mutex_;              ///< guards what follows
  std::condition_variable seen_;
  std::string state_ = "reading", report_ = "null";
  bool state_seen_ = false;
  double start_ = 0, end_ = 0;  ///< of the render, on the steady clock; 0: not yet
  std::deque<std::string> messages_;
  std::shared_ptr<const Image> picture_;
  std::shared_ptr<const std::string> encoded_;  ///< picture_ as a PNG file; null: not made yet
  int picture_number_ = 0, sent_number_ = 0;    ///< of the last picture, and of the last that was sent; 0: none
  HttpServer server_;                           ///< the last member: what its thread uses is there, and it ends first
};

}  // namespace sheaf
