// Jobs run ahead by all threads: results and errors are those of one thread, in bounded memory.
#include "core/io/read_ahead.h"

#include <doctest/doctest.h>

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <atomic>
#include <chrono>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>

namespace sheaf::test_read_ahead {

namespace {

using Jobs = std::vector<ReadAhead<int>::Job>;

/// Jobs that return the square of their index.
Jobs squares(int count, double bytes = 1) {
  Jobs jobs;
  for (int i = 0; i < count; ++i) jobs.push_back({[i] { return i * i; }, bytes});
  return jobs;
}

/// Takes all results; errors become -1.
std::vector<int> take_all(Jobs jobs, double max_bytes) {
  const std::size_t count = jobs.size();
  ReadAhead<int> ahead(std::move(jobs), max_bytes);
  std::vector<int> results;
  for (std::size_t i = 0; i < count; ++i) try {
      results.push_back(ahead.take(i));
    } catch (const std::runtime_error&) { results.push_back(-1); }
  return results;
}

/// Lets oneTBB use this many threads, also on machines with fewer processors.
struct Threads {
  explicit Threads(int count)
      : control(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(count)), arena(count) {}
  tbb::global_control control;
  tbb::task_arena arena;
};

/// Waits until `condition` holds, at most 10 s.
template <class Condition> bool holds_soon(Condition condition) {
  for (int i = 0; i < 10000 && !condition(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  return condition();
}

}  // namespace

TEST_CASE("read ahead: results and errors are those of one thread") {
  Jobs jobs = squares(200);
  jobs[7].run = jobs[150].run = []() -> int { throw std::runtime_error("broken"); };
  const std::vector<int> alone = take_all(jobs, 0);
  CHECK(alone[7] == -1);
  CHECK(alone[150] == -1);
  CHECK(alone[151] == 151 * 151);
  for (const int count : {1, 2, 8}) {
    Threads threads(count);
    for (const double bytes : {1.0, 5.0, 1e9}) threads.arena.execute([&] { CHECK(take_all(jobs, bytes) == alone); });
  }
  CHECK(take_all({}, 1e9).empty());
}

TEST_CASE("read ahead: other threads run jobs before their results are taken") {
  Threads threads(4);
  std::atomic<int> done{0};
  Jobs jobs = squares(20);
  for (auto& job : jobs) job.run = [&done, run = job.run] { return ++done, run(); };
  threads.arena.execute([&] {
    ReadAhead<int> ahead(std::move(jobs), 1e9);
    CHECK(holds_soon([&] { return done == 20; }));
    for (std::size_t i = 0; i < 20; ++i) CHECK(ahead.take(i) == static_cast<int>(i * i));
  });
  CHECK(done == 20);
}

TEST_CASE("read ahead: results beyond the limit of memory wait for their turn") {
  Threads threads(4);
  std::atomic<int> done{0};
  Jobs jobs = squares(20, 10);
  for (auto& job : jobs) job.run = [&done, run = job.run] { return ++done, run(); };
  threads.arena.execute([&] {
    ReadAhead<int> ahead(std::move(jobs), 35);
    CHECK(holds_soon([&] { return done == 3; }));
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    CHECK(done == 3);  // three jobs of 10 bytes
    for (int i = 0; i < 20; ++i) {
      CHECK(ahead.take(static_cast<std::size_t>(i)) == i * i);
      CHECK(done <= i + 1 + 3);
    }
  });
  // Without memory, jobs run when their results are taken.
  done = 0;
  Jobs more = squares(3);
  for (auto& job : more) job.run = [&done, run = job.run] { return ++done, run(); };
  ReadAhead<int> none(std::move(more), 0);
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  CHECK(done == 0);
  CHECK(none.take(1) == 1);
  CHECK(done == 1);
}

TEST_CASE("read ahead: a job that fails ahead of its turn runs again in the thread that takes its result") {
  Threads threads(4);
  const std::thread::id taker = std::this_thread::get_id();
  std::atomic<int> failures{0};
  Jobs jobs = squares(10);
  jobs[5].run = [&]() -> int {
    if (std::this_thread::get_id() == taker) return 55;
    ++failures;
    throw std::bad_alloc();
  };
  threads.arena.execute([&] {
    ReadAhead<int> ahead(std::move(jobs), 1e9);
    CHECK(holds_soon([&] { return failures > 0; }));
    CHECK(ahead.take(5) == 55);
  });
  CHECK(failures == 1);
}

TEST_CASE("read ahead: results that nobody takes are dropped") {
  Threads threads(4);
  threads.arena.execute([] { CHECK_NOTHROW(ReadAhead<int>(squares(1000), 1e9)); });
}

TEST_CASE("read ahead: a share of the memory applies to one thread and ends") {
  const double all = available_memory();
  double here = 0, elsewhere = 0;
  {
    const MemoryFraction fraction(1e-3);
    here = available_memory();
    std::thread([&] { elsewhere = available_memory(); }).join();
  }
  CHECK(here < 0.01 * all);
  CHECK(elsewhere > 0.1 * all);
  CHECK(available_memory() > 0.1 * all);
}

}  // namespace sheaf::test_read_ahead
