// A wave: the paths that one worker has in flight, in memory that fits its L2 cache and that no other worker accesses.
#pragma once

#include "core/color/float4.h"
#include "kernels/wave/beam_scratch.h"
#include "kernels/wave/light_groups.h"
#include "kernels/wave/path_pool.h"
#include "kernels/wave/shading_columns.h"
#include "kernels/wave/wave_stats.h"

#include <optional>

namespace sheaf {

/// Receives every ray packet just before it is traced; for benchmarks.
class RayRecorder {
 public:
  enum class Query { kNearest, kAny };
  virtual ~RayRecorder() = default;
  virtual void record(const RayPacket& packet, int count, Query query) = 0;
};

/// All queues of a worker. The worker itself constructs it, so that its memory is local to the worker's NUMA node.
struct Wave : PathPool, ShadingColumns {
  /// `capacity`: maximum number of paths in flight, at least 1. Columns that `needs` leaves out must not be accessed.
  explicit Wave(int capacity, const WaveNeeds& needs = {});
  Wave(const Wave&) = delete;
  Wave& operator=(const Wave&) = delete;

  /// Bytes of all queues per path.
  static std::size_t bytes_per_path(const WaveNeeds& needs);
  /// Capacity whose queues fill half of the L2 cache: a multiple of 64 in [256, 4096].
  static int default_capacity(const WaveNeeds& needs);

  int capacity;
  WaveNeeds needs;
  Arena arena;

  Stats stats;
  /// First sample that was dropped, for the warning.
  struct Dropped {
    bool any = false;
    std::uint32_t pixel = 0, sample = 0;
  } first_dropped;
  RayRecorder* recorder = nullptr;  ///< optional
  BeamScratch beam;
  std::optional<LightGroupSink> light_groups;  ///< if the film has layers of light groups
  float max_indirect = kInfinity;  ///< limit on the sum over the lanes of each contribution of indirect light
};

/// The part of add_radiance() that limits indirect light, which has been scattered at least twice: scales `found` down
/// to Wave::max_indirect.
Float4 limited_indirect(const Wave& wave, Slot slot, const Float4& found, int scatterings) noexcept;

/// The part of add_radiance() that serves light groups.
void add_to_light_group(Wave& wave, Slot slot, const Float4& found, std::uint32_t light) noexcept;

}  // namespace sheaf
