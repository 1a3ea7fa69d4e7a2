// Tools of trace_limit: a log of rays, its replay, and the null hypothesis.
#pragma once

#include "kernels/wave/wave.h"

#include <cstddef>
#include <cstdint>
#include <ctime>
#include <memory>
#include <mutex>
#include <vector>

namespace sheaf {

/// The rays of one packet before they are traced.
struct alignas(64) PacketRecord {
  float columns[7][kPacketWidth];  ///< origin x, y, z, direction x, y, z, t_far
  int count;                       ///< rays, from the first lane on
  RayRecorder::Query query;
};

/// A duration.
struct Duration {
  double seconds = 0;      ///< wall-clock time
  double cpu_seconds = 0;  ///< of all threads of the process
};

/// Measures time from its construction on.
class Stopwatch {
 public:
  Duration elapsed() const;

 private:
  std::uint64_t start_ = timestamp();
  std::clock_t cpu_start_ = std::clock();
};

/// All rays of a render, in the order in which each worker traced them.
class RayLog {
 public:
  /// Holds at most `max_packets` packets, rounded up to whole blocks.
  explicit RayLog(std::size_t max_packets);
  ~RayLog();

  /// A recorder for one worker, valid as long as the log. May be called by many threads at once.
  RayRecorder* add_worker();
  /// Whether all rays were recorded.
  bool complete() const;
  std::size_t packets() const;
  std::size_t rays() const;

  /// Traces all rays again in the recorded packets. Threads take blocks of packets, as the renderer's workers take
  /// tasks.
  Duration replay(const Accel& accel, int threads) const;

 private:
  class Worker;
  struct Block;

  std::mutex mutex_;
  std::vector<std::unique_ptr<Worker>> workers_;
  std::size_t max_blocks_, blocks_ = 0;
  bool complete_ = true;
};

/// The CPU time of the same kernels with one lane policy and wave size, on one thread.
struct LaneCost {
  const char* lane;  ///< "scalar" or "wide"
  int wave_size;
  double ns_per_ray;         ///< total
  double trace_ns_per_ray;   ///< inside Embree
  double stamps_ns_per_ray;  ///< estimated cost of time stamps, which grows with the number of calls
};

/// Runs the path pass path by path and in waves, with scalar and with wide kernels. Returns medians of `runs` rounds.
std::vector<LaneCost> measure_null_hypothesis(const Scene& scene, int runs);

/// The median: the middle value, or the mean of the two middle values. `values` must not be empty.
double median(std::vector<double> values);

}  // namespace sheaf
