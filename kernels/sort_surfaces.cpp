// Stage: sort. Surface hits by closure kind, then material, so that the stages that follow run one closure at a time.
#include "core/bucket_sort.h"
#include "kernels/stage_timer.h"
#include "kernels/stages.h"

namespace sheaf {

template <class L> void sort_surfaces(const SceneView& scene, Wave& wave) noexcept {
  const int hits = wave.surface.size();
  for (SurfaceRun& run : wave.runs) run = {};
  if (hits == 0) return;
  StageTimer timer(wave.stats, Stage::kSort);
  timer.count(hits, 1);
  constexpr int kMaterialWord = 6;
  static_assert(Groups<HitState>::kWords == 8);
  // Pointers of our own: the compiler must assume that storing a byte may change any of the wave's.
  const Slot* slots = wave.surface.data();
  const float* material_words = wave.hits.row(0) + kMaterialWord;
  const MaterialRow* materials = scene.materials;
  std::uint8_t* keys = wave.sort_keys;
  for (int i = 0; i < hits; ++i) {
    const std::uint32_t material = float_bits(material_words[8 * slots[i]]);
    keys[i] = static_cast<std::uint8_t>(materials[material].bucket);
  }
  int begin[kMaxBuckets + 1];
  bucket_sort(wave.surface.data(), wave.sort_keys, hits, static_cast<int>(scene.bucket_count), wave.sorted.data(),
              begin);
  wave.sorted.resize(hits);
  wave.sorted.pad();
  int column = 0;
  for (int kind = 0; kind < kClosureKinds; ++kind) {
    SurfaceRun& run = wave.runs[kind];
    run.slot_begin = begin[scene.bucket_begin[kind]];
    run.count = begin[scene.bucket_begin[kind + 1]] - run.slot_begin;
    run.column_begin = column;
    column += (run.count + kWidth - 1) / kWidth * kWidth;
  }
  wave.surface.clear();
}

SHEAF_INSTANTIATE_STAGE(sort_surfaces);

}  // namespace sheaf
