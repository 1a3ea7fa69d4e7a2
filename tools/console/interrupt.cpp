// The signal handlers and the only state that they access: lock-free atomics.
#include "tools/console/interrupt.h"

namespace sheaf {

namespace {

constexpr std::array<int, 3> kCaught{SIGINT, SIGTERM, SIGHUP};

std::atomic<bool> stop_requested{false};
std::atomic<int> received_signal{0};
std::atomic<bool> preview_requested{false};
static_assert(std::atomic<bool>::is_always_lock_free && std::atomic<int>::is_always_lock_free);

/// The next SIGINT or SIGTERM terminates the program. Further SIGHUPs are ignored, because closing a terminal may send
/// more than one.
extern "C" void handle_interrupt(int number) {
  received_signal.store(number);
  stop_requested.store(true);
  std::signal(SIGINT, SIG_DFL);
  std::signal(SIGTERM, SIG_DFL);
  std::signal(SIGHUP, SIG_IGN);
}

extern "C" void handle_preview(int) { preview_requested.store(true); }

}  // namespace

InterruptGuard::InterruptGuard() {
  stop_requested = false;
  received_signal = 0;
  struct sigaction action {};
  action.sa_handler = handle_interrupt;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  for (const int number : kCaught) sigaddset(&action.sa_mask, number);  // block the others while the handler runs
  for (std::size_t i = 0; i < kCaught.size(); ++i) {
    sigaction(kCaught[i], nullptr, &old_[i]);
    if (old_[i].sa_handler != SIG_IGN) sigaction(kCaught[i], &action, nullptr);
  }
  struct sigaction ignore {};
  ignore.sa_handler = SIG_IGN;
  sigaction(SIGPIPE, &ignore, &old_[kCaught.size()]);
  preview_requested = false;
  action.sa_handler = handle_preview;
  sigaction(SIGUSR1, &action, &old_[kCaught.size() + 1]);
}

InterruptGuard::~InterruptGuard() {
  for (std::size_t i = 0; i < kCaught.size(); ++i) sigaction(kCaught[i], &old_[i], nullptr);
  sigaction(SIGPIPE, &old_[kCaught.size()], nullptr);
  sigaction(SIGUSR1, &old_[kCaught.size() + 1], nullptr);
}

const std::atomic<bool>& InterruptGuard::stop() { return stop_requested; }

void InterruptGuard::request_stop() { stop_requested = true; }

int InterruptGuard::signal() { return received_signal.load(); }

bool InterruptGuard::wants_preview() { return preview_requested.load(std::memory_order_relaxed); }

void InterruptGuard::end_preview() { preview_requested = false; }

}  // namespace sheaf
