// The paths that one worker has in flight: what each of them carries, reached by slot, and the lists that say what is
// to be done with it next. Knows nothing of cameras and films.
#pragma once

#include "core/slot_list.h"
#include "kernels/wave/path_state.h"
#include "kernels/wave/wave_needs.h"

namespace sheaf {

/// What stages hand to each other: the lists of slots, and rows of columns.
enum class Queue : std::uint32_t {
  kFree,
  kActive,
  kMedium,
  kMiss,
  kEmitter,
  kComposite,
  kSurface,
  kSorted,
  kFinished,  // lists of PathPool
  kVertices,
  kCandidates,
  kShadows,  // rows of ShadingColumns
};
inline constexpr int kSlotLists = static_cast<int>(Queue::kFinished) + 1;

/// Queues as bits.
struct QueueSet {
  std::uint32_t bits = 0;
  template <class... Q>
  constexpr QueueSet(Q... queues) : bits(((1u << static_cast<std::uint32_t>(queues)) | ... | 0u)) {}
  constexpr bool contains(Queue queue) const { return (bits >> static_cast<std::uint32_t>(queue) & 1u) != 0; }
};

/// Paths and lists of their slots. A slot stands in exactly one of the lists between stages, and may stand in `emitter`
/// besides.
struct PathPool {
  SlotTable<RayState> rays;
  SlotTable<HitState> hits;
  SlotTable<PathState> paths;
  SlotTable<RadianceState> radiance;
  SlotTable<RescaledPdfs> rescaled_pdfs;  ///< WaveNeeds::transparency
  /// Spectral mode: what the wavelengths are made of, one word per slot; see kernels/wave/path_wavelengths.h.
  float* wavelength_samples = nullptr;
  float* distance_since_vertex = nullptr;  ///< WaveNeeds::distance: from the last vertex to the ray's origin
  /// WaveNeeds::guides: what the path's first guided vertex was expected to bring, lanes added up; 0: there was none.
  float* guide_references = nullptr;

  // Named by Queue.
  SlotList free;       ///< no path
  SlotList active;     ///< ray to be traced
  SlotList medium;     ///< ray is in a medium
  SlotList miss;       ///< ray left the scene
  SlotList emitter;    ///< ray hit something that emits
  SlotList composite;  ///< ray hit a material that is a choice between others or nothing
  SlotList surface;    ///< ray hit something that will be shaded
  SlotList sorted;     ///< the same, in the order of the shading columns
  SlotList finished;   ///< path has ended, radiance complete

  /// All lists, in the order of Queue.
  static constexpr SlotList PathPool::*kLists[] = {&PathPool::free,    &PathPool::active,  &PathPool::medium,
                                                   &PathPool::miss,    &PathPool::emitter, &PathPool::composite,
                                                   &PathPool::surface, &PathPool::sorted,  &PathPool::finished};

  /// Calls f(group or column, whether it is needed) for all that is reached by slot.
  template <class Pool, class F> static void for_each_state(Pool& pool, const WaveNeeds& needs, F&& f) {
    f(pool.rays, true);
    f(pool.hits, true);
    f(pool.paths, true);
    f(pool.radiance, true);
    f(pool.rescaled_pdfs, needs.transparency);
    f(pool.wavelength_samples, needs.spectral);
    f(pool.distance_since_vertex, needs.distance);
    f(pool.guide_references, needs.guides);
  }
};
static_assert(std::size(PathPool::kLists) == kSlotLists);

}  // namespace sheaf
