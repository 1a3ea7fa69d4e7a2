// SIGUSR1 asks the program to show what there is so far. SIGINT, SIGTERM and SIGHUP: the first asks the program to stop
// and save, another SIGINT or SIGTERM ends it at once.
#pragma once

#include <array>
#include <atomic>
#include <csignal>

namespace sheaf {

/// Catches these signals while it lives, except those that the program was started to ignore; and ignores SIGPIPE, so
/// that nobody needs to read the messages of a program that is to save its work. Only one may live at a time.
class InterruptGuard {
 public:
  InterruptGuard();
  ~InterruptGuard();
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;

  /// Becomes true when a signal arrives.
  static const std::atomic<bool>& stop();
  /// The signal that arrived, or 0.
  static int signal();
  /// Whether SIGUSR1 has arrived since end_preview().
  static bool wants_preview();
  static void end_preview();

 private:
  std::array<struct sigaction, 5> old_{};
};

}  // namespace sheaf
