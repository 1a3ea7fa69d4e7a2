// Stage: free photons. Frees the slots of photons that have ended or left the scene.
#include "kernels/stages/stage_list.h"
#include "kernels/wave/stage_timer.h"

namespace sheaf {

template <class L> void free_photons(const StageContext&, Wave& wave) noexcept {
  const int photons = wave.miss.size() + wave.finished.size();
  StageTimer timer(wave.stats, stage_named<L>("free_photons"));
  timer.count(photons, 1);
  for (const Slot slot : wave.miss.span()) wave.free.push(slot);
  for (const Slot slot : wave.finished.span()) wave.free.push(slot);
  wave.miss.clear();
  wave.finished.clear();
  wave.emitter.clear();
}

SHEAF_INSTANTIATE_STAGE(free_photons);

}  // namespace sheaf
