// Stage: sort surfaces. Sorts surface hits by closure kind, then by material, so that the following stages process one
// closure at a time.
#include "kernels/stages/stage_list.h"
#include "kernels/wave/bucket_sort.h"
#include "kernels/wave/stage_timer.h"

namespace sheaf {

template <class L> void sort_surfaces(const StageContext& context, Wave& wave) noexcept {
  const int hits = wave.surface.size();
  for (VertexRun& run : wave.runs) run = {};
  if (hits == 0) return;
  StageTimer timer(wave.stats, stage_named<L>("sort_surfaces"));
  timer.count(hits, 1);
  // Local pointers: the compiler must assume that storing a byte may modify the pointers of the wave.
  const Slot* slots = wave.surface.data();
  const HitState<Scalar>* states = &wave.hits.row(0);
  const MaterialRow* materials = context.scene.materials.rows;
  std::uint8_t* keys = wave.sort_keys;
  for (int i = 0; i < hits; ++i) keys[i] = static_cast<std::uint8_t>(materials[states[slots[i]].material].bucket);
  int begin[kMaxBuckets + 1];
  bucket_sort(wave.surface.data(), wave.sort_keys, hits, static_cast<int>(context.scene.materials.buckets.count),
              wave.sorted.data(), begin);
  wave.sorted.resize(hits);
  wave.sorted.pad();
  int column = 0;
  for (int kind = 0; kind < kClosureKinds; ++kind) {
    VertexRun& run = wave.runs[kind];
    run.slot_begin = begin[context.scene.materials.buckets.begin[kind]];
    run.count = begin[context.scene.materials.buckets.begin[kind + 1]] - run.slot_begin;
    run.column_begin = column;
    column += (run.count + kWidth - 1) / kWidth * kWidth;
  }
  wave.surface.clear();
}

SHEAF_INSTANTIATE_STAGE(sort_surfaces);

}  // namespace sheaf
