// Loops over ranges by all threads.
#pragma once

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <cstddef>

namespace sheaf {

/// Calls run(begin, end) for ranges that cover [0, count), by all threads of oneTBB; up to `grain` elements by this
/// thread. Threads that wait for others do not run other tasks meanwhile, so the calling task may hold locks.
template <class Run> void parallel_ranges(std::size_t count, const Run& run, std::size_t grain = std::size_t{1} << 14) {
  if (count == 0) return;
  if (count <= grain) return run(std::size_t{0}, count);
  tbb::this_task_arena::isolate([&] {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, grain),
                      [&](const tbb::blocked_range<std::size_t>& range) { run(range.begin(), range.end()); });
  });
}

}  // namespace sheaf
