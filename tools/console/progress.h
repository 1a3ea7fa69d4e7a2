// Progress display of a long computation: percentage, elapsed time, remaining time and speed, as a bar or as log lines.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>
#include <string_view>

namespace sheaf {

/// Counts the work of any number of threads and displays it at intervals. It never shows 100 %.
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

  /// `samples`: number of samples of all the work, for the displayed speed. Time starts now. A bar is kept shorter than
  /// `columns`.
  Progress(Mode mode, std::uint64_t samples, Write write, Clock clock = steady_seconds, Columns columns = {});
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Reports that `done` of `total` units of work are done. Thread-safe and cheap. Calls may come out of order; the
  /// maximum is used.
  void update(std::uint64_t done, std::uint64_t total);
  /// Erases the bar. Later calls of any function do nothing.
  void finish();

  static double steady_seconds();

 private:
  std::string describe(double fraction, double now) const;
  void show(double now);

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
