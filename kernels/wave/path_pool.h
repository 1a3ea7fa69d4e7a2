// The paths that one worker has in flight: their state, addressed by slot, and the queues of slots that wait for a
// stage. Independent of cameras and films.
#pragma once

#include "kernels/guiding/candidate_moments.h"
#include "kernels/wave/path_state.h"
#include "kernels/wave/slot_list.h"
#include "kernels/wave/wave_needs.h"

namespace sheaf {

/// Queues between stages: lists of slots, and rows of columns.
enum class Queue : std::uint32_t {
  kFree,
  kActive,
  kMedium,
  kMiss,
  kEmitter,
  kComposite,
  kSurface,
  kSorted,
  kFinished,  // up to here lists of PathPool
  kVertices,
  kCandidates,
  kShadows,  // from kVertices on rows of ShadingColumns
};
inline constexpr int kSlotLists = static_cast<int>(Queue::kFinished) + 1;

/// A set of queues as bits.
struct QueueSet {
  std::uint32_t bits = 0;
  template <class... Q>
  constexpr QueueSet(Q... queues) : bits(((1u << static_cast<std::uint32_t>(queues)) | ... | 0u)) {}
  constexpr bool contains(Queue queue) const { return (bits >> static_cast<std::uint32_t>(queue) & 1u) != 0; }
};

/// Path states and lists of their slots. Between stages each slot is in exactly one list, or in `emitter` and one more.
struct PathPool {
  SlotTable<RayState> rays;
  SlotTable<HitState> hits;
  SlotTable<PathState> paths;
  SlotTable<RadianceState> radiance;
  SlotTable<RescaledPdfs> rescaled_pdfs;    ///< WaveNeeds::transparency
  SlotTable<ChainStartState> chain_starts;  ///< WaveNeeds::chains
  SlotTable<SegmentState> segments;         ///< WaveNeeds::segments
  /// Spectral mode: the number from which the wavelengths of a path are derived, one word per slot; see
  /// kernels/wave/path_wavelengths.h.
  float* wavelength_samples = nullptr;
  float* times = nullptr;  ///< WaveNeeds::times: see kernels/wave/path_time.h
  /// WaveNeeds::distance: distance from the last vertex to the ray's origin, m.
  float* distance_since_vertex = nullptr;
  /// WaveNeeds::guides: expected contribution of the path's first guided vertex, lanes added up; 0: none yet.
  float* guide_references = nullptr;
  SlotTable<PathMoments> moments;  ///< WaveNeeds::candidate_moments

  // In the order of Queue.
  SlotList free;       ///< unused slots
  SlotList active;     ///< rays to be traced
  SlotList medium;     ///< rays in a medium
  SlotList miss;       ///< rays that left the scene
  SlotList emitter;    ///< rays that hit a light
  SlotList composite;  ///< rays that hit a composite material
  SlotList surface;    ///< rays that hit a surface to be shaded
  SlotList sorted;     ///< `surface` in the order of the shading columns
  SlotList finished;   ///< terminated paths with their final radiance

  /// All lists, in the order of Queue.
  static constexpr SlotList PathPool::*kLists[] = {&PathPool::free,    &PathPool::active,  &PathPool::medium,
                                                   &PathPool::miss,    &PathPool::emitter, &PathPool::composite,
                                                   &PathPool::surface, &PathPool::sorted,  &PathPool::finished};

  /// Calls f(table or column, whether it is needed) for each state that is addressed by slot.
  template <class Pool, class F> static void for_each_state(Pool& pool, const WaveNeeds& needs, F&& f) {
    f(pool.rays, true);
    f(pool.hits, true);
    f(pool.paths, true);
    f(pool.radiance, true);
    f(pool.rescaled_pdfs, needs.transparency);
    f(pool.chain_starts, needs.chains);
    f(pool.segments, needs.segments);
    f(pool.wavelength_samples, needs.spectral);
    f(pool.times, needs.times);
    f(pool.distance_since_vertex, needs.distance);
    f(pool.guide_references, needs.guides);
    f(pool.moments, needs.candidate_moments);
  }
};
static_assert(std::size(PathPool::kLists) == kSlotLists);

}  // namespace sheaf
