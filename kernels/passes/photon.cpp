// The photon pass: traces photons and stores them at surfaces and in media.
#include "kernels/film/light_task.h"
#include "kernels/passes/passes.h"
#include "kernels/stages/stages.h"

namespace sheaf {

template <class L> void run_photon_pass(const StageContext& context, Wave& wave) {
  for (;;) {
    if (2 * wave.free.size() >= wave.capacity) photon_rays<L>(context, wave);
    if (wave.active.empty() && context.photons->left() == 0) break;
    intersect<L>(context, wave);
    medium<L>(context, wave);
    select_materials<L>(context, wave);
    sort_surfaces<L>(context, wave);
    surface_inputs<L>(context, wave);
    store_photons<L>(context, wave);
    textures<L>(context, wave);
    scatter<L>(context, wave);
    free_photons<L>(context, wave);
    assert(wave.free.size() + wave.active.size() == wave.capacity);
  }
}

template void run_photon_pass<SHEAF_STAGE_LANE>(const StageContext&, Wave&);

}  // namespace sheaf
