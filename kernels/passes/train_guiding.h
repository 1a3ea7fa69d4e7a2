// Training passes: camera samples of the whole frame whose only use is to tell the guide where light comes from. Each
// has twice as many as the one before, and is guided by what those before it have told. Their pictures are thrown away:
// what guides the samples of the final picture must not depend on these.
#pragma once

#include "kernels/guiding/guide_field.h"
#include "kernels/passes/worker.h"

#include <functional>

namespace sheaf {

/// How training goes on and ends.
struct GuideTraining {
  std::function<bool()> stopped;                  ///< true ends it
  std::function<void(std::uint64_t)> on_samples;  ///< so many more camera samples were taken
  RenderReport::Guiding report = {};              ///< out
};

/// One training pass.
struct TrainingPass {
  std::uint32_t first_sample = 0, sample_count = 0;  ///< of each pixel that takes part
  int stride = 1;                                    ///< every so many pixels in each direction take part
};

/// The passes for a render of `samples` samples per pixel; none for those too short to gain by it.
std::vector<TrainingPass> training_passes(int width, int height, std::uint32_t samples);

/// Camera samples of all passes.
std::uint64_t training_samples(int width, int height, std::span<const TrainingPass> passes);

/// The guide for a frame. It depends on the scene, the seed, the frame and the passes alone. `context`: of a camera
/// pass with StageContext::guides.
GuideField train_guide(const StageContext& context, Workers& workers, int width, int height,
                       std::span<const TrainingPass> passes, GuideTraining& training);

}  // namespace sheaf
