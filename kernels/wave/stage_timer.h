// Book-keeping that every stage does once per wave.
#pragma once

#include "core/simd.h"
#include "core/stats.h"

namespace sheaf {

/// Counts one call of a stage and the time until it goes out of scope.
class StageTimer {
 public:
  StageTimer(Stats& stats, Stage stage) : stats_(stats[stage]), timer_(stats_.ticks) { ++stats_.calls; }

  /// `items` were worked on `width` at a time: in scalar code (1), registers (kWidth) or packets of several registers.
  void count(int items, int width) {
    const int batches = (items + width - 1) / width * (std::max(width, kWidth) / kWidth);
    stats_.items += static_cast<std::uint64_t>(items);
    stats_.batches += static_cast<std::uint64_t>(batches);
    stats_.active_lanes += static_cast<std::uint64_t>(items);
  }

 private:
  StageStats& stats_;
  ScopedTimer timer_;
};

}  // namespace sheaf
