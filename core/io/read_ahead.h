// Results of jobs, mostly of reading files, computed by all threads before they are needed.
#pragma once

#include "core/io/memory.h"

#include <tbb/task_group.h>

#include <condition_variable>
#include <cstddef>
#include <functional>
#include <mutex>
#include <new>
#include <optional>
#include <utility>
#include <vector>

namespace sheaf {

/// Bytes that all objects of ReadAhead together should hold in results that are not yet taken: a quarter of the
/// available memory. 0 if memory is scarce: nothing is then computed ahead.
double read_ahead_bytes();

/// Number of threads of oneTBB that can help the calling thread, at most `jobs`.
std::size_t read_ahead_helpers(std::size_t jobs);

/// Runs independent jobs by all threads of oneTBB. One thread takes the results and runs those jobs itself that no
/// other thread has begun, so it never waits for a thread that has not started. What it sees does not depend on
/// the number of threads: a job that fails early runs again when its result is taken, where its error
/// counts.
template <class Result> class ReadAhead {
 public:
  struct Job {
    std::function<Result()> run;  ///< must be safe to call from any thread
    double bytes = 0;             ///< estimated peak memory, including the result
  };

  /// Starts the jobs in order. At most `max_bytes` are used ahead of take(), according to Job::bytes.
  ReadAhead(std::vector<Job> jobs, double max_bytes) : slots_(jobs.size()), max_bytes_(max_bytes) {
    for (std::size_t i = 0; i < jobs.size(); ++i) slots_[i].job = std::move(jobs[i]);
    max_helpers_ = max_bytes > 0 && jobs.size() > 1 ? read_ahead_helpers(jobs.size() - 1) : 0;
    add_helpers();
  }
  /// Waits for the jobs that are running; the others are dropped.
  ~ReadAhead() {
    {
      const std::lock_guard lock(mutex_);
      next_ = slots_.size();
    }
    group_.wait();
  }
  ReadAhead(const ReadAhead&) = delete;
  ReadAhead& operator=(const ReadAhead&) = delete;

  /// Returns the result of job `i`, or throws its exception. Call once per job, always from the same thread.
  Result take(std::size_t i) {
    Slot& slot = slots_[i];
    std::unique_lock lock(mutex_);
    // Run other jobs until this one has finished, or wait
    while (slot.state == State::kRunning) {
      lock.unlock();
      const bool helped = run_next();
      lock.lock();
      if (!helped) finished_.wait(lock, [&] { return slot.state != State::kRunning; });
    }
    // Run it here if no other thread has
    if (slot.state == State::kWaiting) {
      slot.state = State::kTaken;
      lock.unlock();
      return slot.job.run();
    }
    Result result = std::move(*slot.result);
    slot.result.reset();
    slot.state = State::kTaken;
    bytes_ahead_ -= slot.job.bytes;
    lock.unlock();
    add_helpers();
    return result;
  }

 private:
  enum class State { kWaiting, kRunning, kFinished, kTaken };
  struct Slot {
    Job job;
    State state = State::kWaiting;
    bool has_failed = false;  ///< before its result was taken
    std::optional<Result> result;
  };

  /// Whether a job may start ahead; moves next_ to it.
  bool find_next() {
    while (next_ < slots_.size() && (slots_[next_].state != State::kWaiting || slots_[next_].has_failed)) ++next_;
    return next_ < slots_.size() && bytes_ahead_ + slots_[next_].job.bytes <= max_bytes_;
  }

  /// Runs one job ahead. Returns false if none may start.
  bool run_next() {
    Slot* slot = nullptr;
    {
      const std::lock_guard lock(mutex_);
      if (max_helpers_ == 0 || !find_next()) return false;
      slot = &slots_[next_++];
      slot->state = State::kRunning;
      bytes_ahead_ += slot->job.bytes;
    }
    std::optional<Result> result;
    try {
      const MemoryFraction fraction(0.5 / static_cast<double>(max_helpers_ + 1));
      result.emplace(slot->job.run());
    } catch (...) {}  // take() runs it again
    const std::lock_guard lock(mutex_);
    slot->has_failed = !result.has_value();
    slot->state = slot->has_failed ? State::kWaiting : State::kFinished;
    if (slot->has_failed) bytes_ahead_ -= slot->job.bytes;
    slot->result = std::move(result);
    finished_.notify_all();
    return true;
  }

  /// Lets more threads help if jobs may start.
  void add_helpers() {
    std::size_t count = 0;
    {
      const std::lock_guard lock(mutex_);
      if (helpers_ < max_helpers_ && find_next()) count = max_helpers_ - helpers_;
      helpers_ += count;
    }
    for (; count > 0; --count)
      group_.run([this] {
        while (run_next()) {}
        const std::lock_guard lock(mutex_);
        --helpers_;
      });
  }

  std::vector<Slot> slots_;
  const double max_bytes_;
  std::size_t max_helpers_ = 0;
  std::mutex mutex_;  ///< of all that follows, and of the states of the slots
  std::condition_variable finished_;
  std::size_t next_ = 0, helpers_ = 0;  ///< first job that may start; tasks that have been started
  double bytes_ahead_ = 0;
  tbb::task_group group_;
};

}  // namespace sheaf
