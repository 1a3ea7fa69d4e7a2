// The debug pass: renders the first surface, or its visibility, without media and light transport.
#include "kernels/passes/passes.h"
#include "kernels/stages/stages.h"

namespace sheaf {

template <class L> void run_debug_pass(const StageContext& from, Wave& wave) {
  StageContext context = from;
  context.transports_light = false;
  for (;;) {
    if (2 * wave.free.size() >= wave.capacity) camera_rays<L>(context, wave);
    if (wave.active.empty()) break;
    intersect<L>(context, wave);
    select_materials<L>(context, wave);
    debug_view<L>(context, wave);
    shadow<L>(context, wave);
    accumulate<L>(context, wave);
    assert(wave.free.size() + wave.active.size() == wave.capacity);
  }
}

template void run_debug_pass<SHEAF_STAGE_LANE>(const StageContext&, Wave&);

}  // namespace sheaf
