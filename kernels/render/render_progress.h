// Progress of a render, as callers display it.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

namespace sheaf {

/// Numbers of samples and photons, training included.
struct RenderProgress {
  std::uint64_t done = 0;    ///< of the whole render, so far
  std::uint64_t total = 0;   ///< of the whole render; an estimate with adaptive sampling and time limits
  std::uint64_t before = 0;  ///< part of `done` that was taken before the render was resumed
  bool is_bound = false;     ///< `total` is an upper bound, because the noise is not known yet
  double until_limit = std::numeric_limits<double>::infinity();  ///< seconds until the time limit ends the render

  /// Part of the render that is done, from 0 to 1.
  double fraction() const {
    return total > 0 ? std::min(static_cast<double>(done) / static_cast<double>(total), 1.0) : 0.0;
  }
  /// Samples per second, `elapsed` seconds after the render was started or resumed.
  double samples_per_second(double elapsed) const {
    return elapsed > 0 && done > before ? static_cast<double>(done - before) / elapsed : 0.0;
  }
  /// Seconds that remain at that speed, or until the time limit; negative: unknown.
  double seconds_left(double elapsed) const {
    const double speed = samples_per_second(elapsed);
    return speed > 0 ? std::min(static_cast<double>(total > done ? total - done : 0) / speed, until_limit) : -1.0;
  }
};

}  // namespace sheaf
