#include "kernels/passes/path.h"

#include "kernels/stages.h"

namespace sheaf {

namespace {

template <class L> void shade_surfaces(const SceneView& scene, Wave& wave) {
  sort_surfaces<L>(scene, wave);
  surface_inputs<L>(scene, wave);
  textures<L>(scene, wave);
  for (wave.candidate = 0; wave.candidate < scene.integrator.candidates; ++wave.candidate) {
    light_candidates<L>(scene, wave);
    resample<L>(scene, wave);
  }
  if (scene.has_transparency) {
    transmittance<L>(scene, wave);
  } else {
    shadow<L>(scene, wave);
  }
  scatter<L>(scene, wave);
}

}  // namespace

template <class L> void run_path_pass(const SceneView& scene, Wave& wave) {
  const bool debugging = scene.integrator.kind != IntegratorKind::kPath;
  for (;;) {
    // Refill when half empty: fewer, fuller calls.
    if (2 * wave.free.size() >= wave.capacity) camera_rays<L>(scene, wave);
    if (wave.active.empty()) break;
    intersect<L>(scene, wave);
    if (!debugging) {
      medium<L>(scene, wave);
      emission<L>(scene, wave);
    }
    select_materials<L>(scene, wave);
    if (debugging) debug_view<L>(scene, wave);
    else shade_surfaces<L>(scene, wave);
    accumulate<L>(scene, wave);
    assert(wave.free.size() + wave.active.size() == wave.capacity);
  }
}

template void run_path_pass<Wide>(const SceneView&, Wave&);
template void run_path_pass<Scalar>(const SceneView&, Wave&);

}  // namespace sheaf
