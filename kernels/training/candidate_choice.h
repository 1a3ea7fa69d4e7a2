// Chooses the number of light candidates per vertex from a training pass; see kernels/guiding/candidate_moments.h.
#pragma once

#include "kernels/training/compared_pass.h"
#include "scene/tables/scene_view.h"

namespace sheaf {

/// The most efficient number of light candidates.
struct CandidateChoice {
  int count = 1;  ///< of kCandidateCounts, the one with the lowest product of error and cost
  /// Efficiency of each of kCandidateCounts relative to one candidate: (error x cost of 1) / (error x cost of M).
  std::array<double, std::size(kCandidateCounts)> gains{1, 1, 1, 1};
};

/// Time of a light candidate of this scene over the time per ray, shading included.
double candidate_cost(const SceneView& scene);

/// The number among kCandidateCounts with the lowest product of error and cost. It is above 1 only if it gains 5 % or
/// more, and twice the standard error of that estimate by the jackknife. The error is that of guiding_gain(). The cost
/// is the number of rays plus `cost` for each candidate.
CandidateChoice choose_candidates(const ComparedPass& pass, double cost);

}  // namespace sheaf
