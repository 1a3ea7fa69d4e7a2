// Training passes of path guiding: camera samples of the whole frame that only train the guide. Each pass is guided by
// what the previous ones have learned. Their images are discarded, because the guide must not depend on the samples of
// the final image that it guides. The first kTrialPasses passes also estimate the gain of guiding (guiding_gain()) and
// how many light candidates do (choose_candidates()).
#pragma once

#include "kernels/guiding/guide_field.h"
#include "kernels/passes/render_report.h"
#include "kernels/passes/worker.h"
#include "kernels/training/candidate_choice.h"
#include "kernels/training/guiding_gain.h"
#include "kernels/training/guiding_mode.h"

#include <functional>

namespace sheaf {

/// Callbacks and results of training.
struct GuideTraining {
  std::function<bool()> stopped;                  ///< true ends training
  std::function<void(std::uint64_t)> on_samples;  ///< progress: more camera samples were taken
  RenderReport::Guiding report = {};              ///< out
  CandidateChoice candidates = {};                ///< out, if passes compare light candidates
};

/// One training pass. The pixels of a pass are evenly distributed over the frame.
struct TrainingPass {
  /// Each participating pixel takes the pairs [first_pair, first_pair + pairs) of sets of samples.
  std::uint32_t first_pair = 0, pairs = 0;
  /// kTrialSet in the passes that are compared. Later passes take single samples of more pixels, from which the guide
  /// learns more.
  std::uint32_t set_samples = 1;
  /// Every `column_stride`-th pixel of every `row_stride`-th row participates.
  int column_stride = 1, row_stride = 1;

  /// Number of samples per participating pixel.
  std::uint32_t samples() const { return 2 * pairs * set_samples; }
  bool operator==(const TrainingPass&) const = default;
};

/// Passes for a render of `samples` samples per pixel, whose mode is not kOff; empty for renders too short to benefit.
/// The first two are equally large. Together they take at most 3/16 of the samples of the render, apart from rounding
/// in frames of few pixels.
std::vector<TrainingPass> training_passes(int width, int height, std::uint32_t samples, GuidingMode mode);

/// Whether a render with training passes is long and large enough for GuidingMode::kAuto and for a comparison of light
/// candidates.
bool is_trial_worthwhile(int width, int height, std::uint32_t samples);

/// Whether the first training passes are also a trial of light candidates, which chooses their number.
bool wants_candidate_trial(const IntegratorSettings& integrator, int width, int height, std::uint32_t samples);

/// Number of camera samples of all passes.
std::uint64_t training_samples(int width, int height, std::span<const TrainingPass> passes);

/// Trains the guide for a frame. It depends only on scene, seed, frame and passes. `context`: of a path pass. With
/// GuidingMode::kAuto, training ends as soon as guiding is not promising, or after the trial if it does not pay.
/// `has_trial`: the passes of the trial try light candidates, and the following ones have the number that pays.
GuideField train_guide(const StageContext& context, Workers& workers, int width, int height,
                       std::span<const TrainingPass> passes, GuidingMode mode, bool has_trial, GuideTraining& training);

}  // namespace sheaf
