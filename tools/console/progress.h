// Progress display of a render: percentage, elapsed time, remaining time and speed, as a bar or as log lines.
#pragma once

#include "kernels/render/render_progress.h"

#include <atomic>
#include <functional>
#include <mutex>
#include <string>
#include <string_view>

namespace sheaf {

/// Displays the progress that any number of threads report, at intervals. It never shows 100 %.
class Progress {
 public:
  enum class Mode {
    kQuiet,  ///< shows nothing
    kLines,  ///< a line every 10 seconds, for logs
    kBar     ///< one line, redrawn ten times a second, for terminals
  };

  /// Output function; called by one thread at a time.
  using Write = std::function<void(std::string_view)>;
  /// Seconds since a fixed moment; thread-safe.
  using Clock = std::function<double()>;
  /// Width of the terminal in characters; 0: unknown. Called by one thread at a time.
  using Columns = std::function<int()>;

  /// Time starts now. A bar is kept shorter than `columns`.
  explicit Progress(Mode mode, Write write, Clock clock = steady_seconds, Columns columns = {});
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Thread-safe and cheap. Calls may come out of order; the maximum of `done` is used.
  void update(const RenderProgress& progress);
  /// Erases the bar. Later calls of any function do nothing.
  void finish();

  static double steady_seconds();

 private:
  std::string describe(const RenderProgress& progress, double now) const;
  void show(RenderProgress progress, double now);

  const Mode mode_;
  const Write write_;
  const Clock clock_;
  const Columns columns_;
  const double start_;
  std::atomic<std::uint64_t> done_{0};
  std::atomic<double> next_show_;
  std::mutex printing_;
  bool finished_ = false;  ///< guarded by printing_
};

}  // namespace sheaf
