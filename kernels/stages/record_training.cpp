// Stage: record training. Adds the radiance of finished paths to the training samples of the guide. The scatter stage
// has already recorded their vertices.
#include "kernels/guiding/guide_record.h"
#include "kernels/stages/stage_list.h"
#include "kernels/wave/stage_timer.h"

namespace sheaf {

template <class L> void record_training(const StageContext& context, Wave& wave) noexcept {
  StageTimer timer(wave.stats, stage_named<L>("record_training"));
  timer.count(wave.finished.size(), 1);
  for (const Slot slot : wave.finished.span()) {
    const RadianceState<Scalar>& row = wave.radiance.row(slot);
    context.training_samples().finish(row.task_sample & ~kTransparent, total(row.radiance));
  }
}

SHEAF_INSTANTIATE_STAGE(record_training);

}  // namespace sheaf
