// Training of the guide by training passes (kernels/training/training_passes.h).
#pragma once

#include "kernels/guiding/guide_field.h"
#include "kernels/passes/render_report.h"
#include "kernels/passes/worker.h"
#include "kernels/training/candidate_choice.h"
#include "kernels/training/guiding_gain.h"
#include "kernels/training/guiding_mode.h"
#include "kernels/training/training_passes.h"

#include <functional>

namespace sheaf {

/// Callbacks and results of training.
struct GuideTraining {
  std::function<bool()> stopped;                  ///< true ends training
  std::function<void(std::uint64_t)> on_samples;  ///< progress: more camera samples were taken
  RenderReport::Guiding report = {};              ///< out
  CandidateChoice candidates = {};                ///< out, if passes compare light candidates
};

/// Trains the guide for a frame. It depends only on scene, seed, frame and passes. `context`: of a path pass. With
/// GuidingMode::kAuto, training ends as soon as guiding is not promising, or after the comparison if it is not worth
/// its cost. `has_comparison`: the first passes compare numbers of light candidates, and the following ones use the
/// best.
GuideField train_guide(const StageContext& context, Workers& workers, int width, int height,
                       std::span<const TrainingPass> passes, GuidingMode mode, bool has_comparison,
                       GuideTraining& training);

}  // namespace sheaf
