// Statistics that each stage records once per wave.
#pragma once

#include "core/simd/simd.h"
#include "kernels/wave/wave_stats.h"

namespace sheaf {

/// Counts one call of a stage and measures the time until it goes out of scope.
class StageTimer {
 public:
  StageTimer(Stats& stats, Stage stage) : stats_(stats[stage]), timer_(stats_.ticks) { ++stats_.calls; }

  /// Counts `items` that were processed `width` at a time: 1 in scalar code, kWidth in registers, more in packets of
  /// several registers.
  void count(int items, int width) {
    const int batches = (items + width - 1) / width * (std::max(width, kWidth) / kWidth);
    count_lanes(items, static_cast<std::uint64_t>(batches), static_cast<std::uint64_t>(items));
  }
  /// Counts `items` whose lanes hold something else: `active` of those in `registers`.
  void count_lanes(int items, std::uint64_t registers, std::uint64_t active) {
    stats_.items += static_cast<std::uint64_t>(items);
    stats_.batches += registers;
    stats_.active_lanes += active;
  }

 private:
  StageStats& stats_;
  TickTimer timer_;
};

}  // namespace sheaf
