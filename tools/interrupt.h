// SIGINT and SIGTERM: the first asks the program to stop and save, the second ends it at once.
#pragma once

#include <atomic>
#include <csignal>

namespace sheaf {

/// Catches both signals while it lives, except those that the program was started to ignore. Only one may live at a
/// time.
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

 private:
  struct sigaction old_interrupt_ {}, old_terminate_ {};
};

}  // namespace sheaf
