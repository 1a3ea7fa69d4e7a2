#include "core/io/read_ahead.h"

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>

namespace sheaf {

double read_ahead_bytes() {
  constexpr double kMinBytes = 64e6;
  const double bytes = available_memory() / 4;
  return bytes < kMinBytes ? 0 : bytes;
}

std::size_t read_ahead_helpers(std::size_t jobs) {
  const auto arena = static_cast<std::size_t>(std::max(1, tbb::this_task_arena::max_concurrency()));
  const std::size_t allowed = tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
  return std::min(std::min(arena, allowed) - 1, jobs);
}

}  // namespace sheaf
