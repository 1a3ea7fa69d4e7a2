// The progress of a long computation: percentage, time spent, time left and speed, as a bar or as log lines.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>
#include <string_view>

namespace sheaf {

/// Seconds as "m:ss", or "h:mm:ss" from one hour on. Negative or not finite: "?:??".
std::string format_duration(double seconds);

/// Counts work done by any number of threads and shows it now and then. It never shows 100 % before finish(true).
class Progress {
 public:
  enum class Mode {
    kQuiet,  ///< shows nothing
    kLines,  ///< a line every 10 seconds and one at the end, for logs
    kBar     ///< one line, redrawn ten times a second, for terminals
  };

  /// Where the text goes; called by one thread at a time.
  using Write = std::function<void(std::string_view)>;
  /// Seconds from any fixed moment on; thread-safe.
  using Clock = std::function<double()>;
  /// How many characters a line of the terminal holds; 0: unknown. Called by one thread at a time.
  using Columns = std::function<int()>;

  /// `samples` is what all work together amounts to, for the speed shown. Time starts now. A bar is
  /// kept shorter than `columns`.
  Progress(Mode mode, std::uint64_t samples, Write write, Clock clock = steady_seconds, Columns columns = {});
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// `done` of `total` units of work are done. Thread-safe and cheap; calls may come out of order: the most counts.
  void update(std::uint64_t done, std::uint64_t total);
  /// Shows the last state and ends the line. `complete`: all work is done; otherwise it was interrupted.
  /// Later calls of any function do nothing.
  void finish(bool complete);

  static double steady_seconds();

 private:
  std::string describe(double fraction, int percent, double now, const char* end) const;
  void show(double now, bool last, bool complete);

  const Mode mode_;
  const double samples_;
  const Write write_;
  const Clock clock_;
  const Columns columns_;
  const double start_;
  std::atomic<std::uint64_t> done_{0}, total_{0};
  std::atomic<double> next_show_;
  std::mutex printing_;
  bool finished_ = false;  ///< guarded by printing_
};

}  // namespace sheaf
