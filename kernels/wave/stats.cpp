// Sums and ratios of the counters of a stage, and the length of a tick.
#include "kernels/wave/stats.h"

#include "core/simd/simd.h"

#include <chrono>

namespace sheaf {

namespace {

double ratio(double a, double b) { return b > 0 ? a / b : 0.0; }

double measure_seconds_per_tick() {
  using Clock = std::chrono::steady_clock;
  constexpr std::chrono::milliseconds kSpan{5};
  const Clock::time_point start = Clock::now();
  const std::uint64_t first = timestamp();
  Clock::time_point now = start;
  while (now - start < kSpan) now = Clock::now();
  const std::uint64_t last = timestamp();
  return std::chrono::duration<double>(now - start).count() / static_cast<double>(last - first);
}

}  // namespace

double seconds_per_tick() {
  static const double seconds = measure_seconds_per_tick();
  return seconds;
}

StageStats& StageStats::operator+=(const StageStats& other) {
  calls += other.calls;
  items += other.items;
  batches += other.batches;
  active_lanes += other.active_lanes;
  ticks += other.ticks;
  return *this;
}

double StageStats::ns_per_item() const { return ratio(seconds() * 1e9, static_cast<double>(items)); }

double StageStats::lane_fill() const {
  return ratio(static_cast<double>(active_lanes), static_cast<double>(batches) * kWidth);
}

}  // namespace sheaf
