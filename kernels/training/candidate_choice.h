// Chooses the number of light candidates per vertex from a trial; see kernels/guiding/candidate_trial.h.
#pragma once

#include "kernels/training/trial_pass.h"
#include "scene/tables/scene_view.h"

namespace sheaf {

/// Whether more light candidates pay.
struct CandidateChoice {
  int count = 1;  ///< the number that pays best
  /// How many times the cost of a render with each of kCandidateCounts one with one candidate needs for the same error:
  /// the ratio of the products of error and cost.
  std::array<double, std::size(kCandidateCounts)> gains{1, 1, 1, 1};
};

/// Time of a light candidate of this scene over the time per ray, shading included.
double candidate_cost(const SceneView& scene);

/// The number among kCandidateCounts with the lowest product of error and cost. It is above 1 only if it gains 5 % or
/// more, and twice the standard error of that estimate by the jackknife. The error is that of guiding_gain(). The cost
/// is the number of rays plus `cost` for each candidate.
CandidateChoice choose_candidates(const TrialPass& pass, double cost);

}  // namespace sheaf
