// What trace_limit measures with: a log of rays, its replay, and the null hypothesis.
#pragma once

#include "kernels/wave/wave.h"

#include <cstddef>
#include <cstdint>
#include <ctime>
#include <memory>
#include <mutex>
#include <vector>

namespace sheaf {

/// Rays of one packet as they were before they were traced.
struct alignas(64) PacketRecord {
  float columns[7][kPacketWidth];  ///< origin x, y, z, direction x, y, z, t_far
  int count;                       ///< rays, from the first lane on
  RayRecorder::Query query;
};

/// How long something took.
struct Duration {
  double seconds = 0;      ///< by the clock on the wall
  double cpu_seconds = 0;  ///< of all threads of the process
};

/// Measures from its construction on.
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
  /// Whether nothing had to be left out.
  bool complete() const;
  std::size_t packets() const;
  std::size_t rays() const;

  /// Traces all rays again, packet by packet as they were recorded. Threads take blocks of packets, as the renderer's
  /// workers take tasks.
  Duration replay(const Accel& accel, int threads) const;

 private:
  class Worker;
  struct Block;

  std::mutex mutex_;
  std::vector<std::unique_ptr<Worker>> workers_;
  std::size_t max_blocks_, blocks_ = 0;
  bool complete_ = true;
};

/// The price of the same kernels at one lane policy and wave size, on one thread, in CPU time.
struct LaneCost {
  const char* lane;  ///< "scalar" or "wide"
  int wave_size;
  double ns_per_ray;         ///< everything
  double trace_ns_per_ray;   ///< inside Embree
  double stamps_ns_per_ray;  ///< spent on time stamps, which grow with the number of calls; an estimate
};

/// Runs the path pass path by path and wave by wave, with scalar and with wide kernels; medians of `runs` rounds.
std::vector<LaneCost> measure_null_hypothesis(const Scene& scene, int runs);

/// The middle one; the mean of the two in the middle if their number is even. `values` must not be empty.
double median(std::vector<double> values);

}  // namespace sheaf
