// A wave: the paths one worker has in flight, in memory that fits its L2 cache and that no other worker touches.
#pragma once

#include "core/float4.h"
#include "core/stats.h"
#include "kernels/photons/volume_photon_map.h"
#include "kernels/wave/light_groups.h"
#include "kernels/wave/path_pool.h"
#include "kernels/wave/shading_columns.h"

namespace sheaf {

/// Sees every packet just before it is traced; for benchmarks.
class RayRecorder {
 public:
  enum class Query { kNearest, kAny };
  virtual ~RayRecorder() = default;
  virtual void record(const RayPacket& packet, int count, Query query) = 0;
};

/// All of a worker's queues. Constructed by the worker itself, so that its memory is local to it.
struct Wave : PathPool, ShadingColumns {
  /// `capacity`: paths in flight; at least 1. Columns that `needs` leaves out must not be touched.
  explicit Wave(int capacity, const WaveNeeds& needs = {});
  Wave(const Wave&) = delete;
  Wave& operator=(const Wave&) = delete;

  /// Bytes of all queues per path.
  static std::size_t bytes_per_path(const WaveNeeds& needs);
  /// The capacity whose queues fill half of the L2 cache: a multiple of 64 in [256, 4096].
  static int default_capacity(const WaveNeeds& needs);

  int capacity;
  WaveNeeds needs;
  Arena arena;

  Stats stats;
  /// First sample that was dropped, for the message.
  struct Dropped {
    bool any = false;
    std::uint32_t pixel = 0, sample = 0;
  } first_dropped;
  RayRecorder* recorder = nullptr;
  BeamScratch beam;
  LightGroupSink light_groups;
};

/// add_radiance() for light groups alone.
void add_to_light_group(Wave& wave, Slot slot, const Float4& found, std::uint32_t light) noexcept;

}  // namespace sheaf
