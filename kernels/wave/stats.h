// Timers, and the counters of one stage.
#pragma once

#include "core/simd/timestamp.h"

#include <cstdint>

namespace sheaf {

/// The length of one tick of timestamp() in seconds. The first call measures it for 5 ms; thread-safe.
double seconds_per_tick();

/// Counters of one stage.
struct StageStats {
  std::uint64_t calls = 0;         ///< times the stage ran on a wave
  std::uint64_t items = 0;         ///< queue entries consumed
  std::uint64_t batches = 0;       ///< SIMD registers processed
  std::uint64_t active_lanes = 0;  ///< lanes of those registers that held an item; at most batches * kWidth
  std::uint64_t ticks = 0;         ///< of timestamp()

  StageStats& operator+=(const StageStats& other);
  double seconds() const { return static_cast<double>(ticks) * seconds_per_tick(); }
  /// Nanoseconds per item; 0 without items.
  double ns_per_item() const;
  /// Fraction of the SIMD lanes that did useful work, in [0, 1]; 0 without batches.
  double lane_fill() const;
};

/// Adds the time between its construction and its destruction to a sum of ticks.
class TickTimer {
 public:
  explicit TickTimer(std::uint64_t& sum) : sum_(sum), start_(timestamp()) {}
  ~TickTimer() { sum_ += timestamp() - start_; }
  TickTimer(const TickTimer&) = delete;
  TickTimer& operator=(const TickTimer&) = delete;

 private:
  std::uint64_t& sum_;
  std::uint64_t start_;
};

}  // namespace sheaf
