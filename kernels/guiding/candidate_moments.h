// Moments of paths by the number of light candidates: a pass with kMaxComparedCandidates light candidates per vertex
// estimates the variance of paths with fewer.
//
// Next-event estimation with M candidates of resampling weight W_i = q(x_i) / p(x_i) contributes I = V(y) 1/M sum W_i,
// where y is kept in proportion to W and V is visibility. With the law of total variance, over y and then over the x_i,
//     E[I^2] = A / M + (1 - 1/M) B,   A = E[W^2 V^2],   B = E[W] E[W V^2].
// All candidates of a vertex and its one shadow ray give unbiased estimates of A, B and E[I] = E[W V], for every M,
// with the MIS weights of that M. The estimate of the squared radiance of a path with M candidates is the square of the
// sum of E[I] and of emission that it finds, plus E[I^2] - E[I]^2 of each vertex.
#pragma once

#include "core/color/spectrum.h"

namespace sheaf {

/// Numbers of candidates that a pass compares. Values for each of them are the lanes of a Spectrum or Float4.
inline constexpr int kCandidateCounts[] = {1, 2, 4, 8};
inline constexpr int kMaxComparedCandidates = 8;

/// Resampling weights, spectral lanes added up, with the MIS weights of each number of candidates. Same row as its
/// VertexItem.
template <class L> struct CandidateWeights {
  Spectrum<L> sum;   ///< of all candidates
  Spectrum<L> kept;  ///< of the kept one
  static constexpr auto fields(auto& s) { return std::tie(s.sum, s.kept); }
};

/// Moments of a path's radiance, spectral lanes added up, for each number of candidates.
template <class L> struct PathMoments {
  Spectrum<L> radiance;        ///< estimates of the radiance
  Spectrum<L> excess;          ///< estimates of the squared radiance, less the square of `radiance`
  Spectrum<L> pending;         ///< added to `radiance` if the shadow ray of the last vertex is unoccluded
  Spectrum<L> pending_excess;  ///< the same of `excess`
  static constexpr auto fields(auto& s) { return std::tie(s.radiance, s.excess, s.pending, s.pending_excess); }
};

}  // namespace sheaf
