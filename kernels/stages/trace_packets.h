// The loop around Embree that all stages share: packets of sixteen rays, recorded for benchmarks and timed.
#pragma once

#include "kernels/wave/wave.h"
#include "scene/accel/accel.h"
#include "scene/tables/scene_view.h"

#include <algorithm>

namespace sheaf {

/// Traces `rays` rays. pack(first, count, packet) fills the lanes of the packet with the rays [first, first + count).
/// take(first, count, packet) receives their hits.
template <class Pack, class Take>
SHEAF_INLINE void trace_packets(const SceneView& scene, Wave& wave, int rays, RayRecorder::Query query, Pack&& pack,
                                Take&& take) {
  RayPacket packet;
  for (int first = 0; first < rays; first += kPacketWidth) {
    const int count = std::min(kPacketWidth, rays - first);
    pack(first, count, packet);
    if (wave.recorder) wave.recorder->record(packet, count, query);
    const std::uint64_t start = timestamp();
    if (query == RayRecorder::Query::kNearest) {
      scene.accel->intersect(packet, count);
    } else {
      scene.accel->occluded(packet, count);
    }
    wave.stats.trace_ticks += timestamp() - start;
    take(first, count, packet);
  }
}

}  // namespace sheaf
