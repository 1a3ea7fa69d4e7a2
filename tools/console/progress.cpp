// Counting of work, and its display as a bar or as log lines.
#include "tools/console/progress.h"

#include "tools/console/duration.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

namespace sheaf {

namespace {

constexpr double kBarInterval = 0.1, kLineInterval = 10.0;
constexpr int kBarCells = 24;

std::string draw_bar(double fraction) {
  const auto filled = static_cast<std::size_t>(std::clamp(fraction, 0.0, 1.0) * kBarCells);
  return fmt::format("[{}{}] ", std::string(filled, '#'), std::string(kBarCells - filled, '.'));
}

}  // namespace

double Progress::steady_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

Progress::Progress(Mode mode, Write write, Clock clock, Columns columns)
    : mode_(mode),
      write_(std::move(write)),
      clock_(std::move(clock)),
      columns_(std::move(columns)),
      start_(clock_()),
      next_show_(start_ + (mode == Mode::kLines ? kLineInterval : 0.0)) {}

void Progress::update(const RenderProgress& progress) {
  if (mode_ == Mode::kQuiet) return;
  std::uint64_t seen = done_.load(std::memory_order_relaxed);
  while (seen < progress.done && !done_.compare_exchange_weak(seen, progress.done, std::memory_order_relaxed)) {}
  const double now = clock_();
  if (now < next_show_.load(std::memory_order_relaxed)) return;
  const std::unique_lock lock(printing_, std::try_to_lock);
  if (!lock || finished_ || now < next_show_.load(std::memory_order_relaxed)) return;
  next_show_ = now + (mode_ == Mode::kLines ? kLineInterval : kBarInterval);
  show(progress, now);
}

void Progress::finish() {
  if (mode_ == Mode::kQuiet) return;
  const std::lock_guard lock(printing_);
  if (finished_) return;
  finished_ = true;
  if (mode_ == Mode::kBar) write_("\r\x1b[K");
}

std::string Progress::describe(const RenderProgress& progress, double now) const {
  const double elapsed = now - start_, fraction = progress.fraction();
  const std::string percentage = fmt::format("{:3} %", std::min(static_cast<int>(100 * fraction), 99)),
                    time = fmt::format("  {} elapsed", format_duration(elapsed)),
                    rest = fmt::format(", {}{} left", progress.is_bound ? "at most " : "",
                                       format_duration(progress.seconds_left(elapsed))),
                    rate = fmt::format(", {:.2f} Msamples/s", progress.samples_per_second(elapsed) * 1e-6);
  if (mode_ != Mode::kBar) return percentage + time + rest + rate;
  // A line as long as the terminal is wide would scroll it. Leave out the least important parts first.
  const int columns = columns_ ? columns_() : 0;
  const std::size_t room = columns > 0 ? static_cast<std::size_t>(columns) - 1 : std::string::npos;
  for (const std::string& line : {draw_bar(fraction) + percentage + time + rest + rate, percentage + time + rest + rate,
                                  percentage + time + rest, percentage + rest})
    if (line.size() <= room) return line;
  return percentage.substr(0, room);
}

void Progress::show(RenderProgress progress, double now) {
  progress.done = done_.load();
  const std::string text = describe(progress, now);
  write_(mode_ == Mode::kBar ? fmt::format("\r{}\x1b[K", text) : text + "\n");
}

}  // namespace sheaf
