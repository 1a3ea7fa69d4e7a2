// Stage: accumulate. Finished paths become samples of the task; the film takes those in order at the task's end
// (kernels/passes/render.cpp).
#include "kernels/stage_timer.h"
#include "kernels/stages.h"

#include <cmath>
#include <limits>

namespace sheaf {

template <class L> void accumulate(const SceneView&, Wave& wave) noexcept {
  const int paths = wave.finished.size();
  if (paths == 0) return;
  StageTimer timer(wave.stats, Stage::kAccumulate);
  timer.count(paths, 1);
  for (int i = 0; i < paths; ++i) {
    const Slot slot = wave.finished[i];
    const RadianceState<Scalar> r = wave.radiance.get(slot);
    FilmSample& out = wave.task_samples[r.task_sample & ~kTransparent];
    const float sum = r.radiance.c0 + r.radiance.c1 + r.radiance.c2;
    const bool good = std::isfinite(sum * r.weight) && r.radiance.c0 >= 0.0f && r.radiance.c1 >= 0.0f &&
                      r.radiance.c2 >= 0.0f;
    if (good) {
      out = {r.radiance.c0 * r.weight, r.radiance.c1 * r.weight, r.radiance.c2 * r.weight,
             r.task_sample & kTransparent ? 0.0f : r.weight};
      ++wave.stats.samples;
    } else {
      out.alpha = std::numeric_limits<float>::quiet_NaN();
      ++wave.stats.dropped.samples;
      const ThroughputState<Scalar> path = wave.throughput.get(slot);
      if (!wave.first_dropped.any) wave.first_dropped = {true, path.pixel, path.sample};
    }
    wave.free.push(slot);
  }
  wave.finished.clear();
}

SHEAF_INSTANTIATE_STAGE(accumulate);

}  // namespace sheaf
