// The path pass: traces paths from camera samples and stores their radiance as samples of the film. With photon maps,
// paths end where a map provides the remaining radiance.
#include "kernels/passes/passes.h"
#include "kernels/stages/stages.h"

namespace sheaf {

template <class L> void run_path_pass(const StageContext& context, Wave& wave) {
  for (;;) {
    // Refill when half of the slots are free: fewer calls that fill more lanes.
    if (2 * wave.free.size() >= wave.capacity) camera_rays<L>(context, wave);
    if (wave.active.empty()) break;
    intersect<L>(context, wave);
    gather_volume<L>(context, wave);
    medium<L>(context, wave);
    emission<L>(context, wave);
    select_materials<L>(context, wave);
    sort_surfaces<L>(context, wave);
    surface_inputs<L>(context, wave);
    textures<L>(context, wave);
    aovs<L>(context, wave);
    gather<L>(context, wave);
    guide<L>(context, wave);
    for (int candidate = 0; candidate < context.integrator.candidates; ++candidate) {
      light_candidates<L>(context, wave, candidate);
      resample<L>(context, wave, candidate);
    }
    if (context.scene.needs_transmittance)
      transmittance<L>(context, wave);
    else
      shadow<L>(context, wave);
    scatter<L>(context, wave);
    record_training<L>(context, wave);
    accumulate<L>(context, wave);
    assert(wave.free.size() + wave.active.size() == wave.capacity);
  }
}

template void run_path_pass<SHEAF_STAGE_LANE>(const StageContext&, Wave&);

}  // namespace sheaf
