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
    const std::uint32_t path = row.task_sample & ~kTransparent;
    context.training_samples().finish(path, total(row.radiance));
    if (!context.compares_candidates()) continue;
    const PathMoments<Scalar>& moments = wave.moments.row(slot);
    context.training_samples().finish_moments(path, moments.radiance, moments.excess);
  }
}

SHEAF_INSTANTIATE_STAGE(record_training);

}  // namespace sheaf
