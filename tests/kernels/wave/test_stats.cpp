// Ratios of the counters of a stage, and time stamps.
#include "kernels/wave/stats.h"

#include "core/simd/simd.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

#include <thread>

namespace sheaf::test_stats {

TEST_CASE("ratios are defined for empty statistics") {
  const StageStats stage{1, 100, 10, 5 * kWidth, 1000};
  CHECK(stage.lane_fill() == near(0.5));
  CHECK(stage.ns_per_item() == near(10 * seconds_per_tick() * 1e9));
  CHECK(StageStats().lane_fill() == 0);
  CHECK(StageStats().ns_per_item() == 0);
}

TEST_CASE("ticks measure time") {
  const auto start = std::chrono::steady_clock::now();
  std::uint64_t ticks = 0;
  {
    const TickTimer timer(ticks);
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  const double limit = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const double seconds = static_cast<double>(ticks) * seconds_per_tick();
  CHECK(seconds > 0.05 * 0.99);
  CHECK(seconds < limit * 1.01);
}

}  // namespace sheaf::test_stats
