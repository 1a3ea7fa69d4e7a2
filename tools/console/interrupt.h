// Signal handling. SIGUSR1 requests a preview of the image so far. The first SIGINT, SIGTERM or SIGHUP requests that
// the program saves its work and stops. A second SIGINT or SIGTERM terminates it immediately.
#pragma once

#include <array>
#include <atomic>
#include <csignal>

namespace sheaf {

/// Catches these signals during its lifetime, except those of stop requests that the program was started to ignore.
/// Also ignores SIGPIPE, so that a closed message stream does not end a program that must save its work. Only one
/// instance may exist at a time.
class InterruptGuard {
 public:
  InterruptGuard();
  ~InterruptGuard();
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;

  /// Becomes true when a stop request arrives.
  static const std::atomic<bool>& stop();
  /// Requests to stop without a signal. Thread-safe.
  static void request_stop();
  /// The signal of the stop request, or 0.
  static int signal();
  /// Whether SIGUSR1 has arrived since the last end_preview().
  static bool wants_preview();
  static void end_preview();

 private:
  std::array<struct sigaction, 5> old_{};
};

}  // namespace sheaf
