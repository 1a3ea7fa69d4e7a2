// Fits the mixture of a guide cell to training samples by expectation maximization (EM).
//
// At a vertex, paths sample the mixture a p_b + (1 - a) sum_k s_k v_k of the BSDF p_b and the lobes v_k. EM over
// directions, weighted by their light over their pdf, minimizes the Kullback-Leibler divergence of this mixture from
// the integrand. Mueller ("Practical Path Guiding in Production", 2019) learns the weight `a` with the same objective.
// Here the BSDF is one component of the mixture, with a given shape: the lobes learn the rest, and `a` needs no
// learning rate.
//
// The sums over directions are kept between training passes with decaying weight. They count effective samples, so the
// findings of a few bright paths count as few samples. The priors are as in Ruppert, Herholz and Lensch 2020, section
// 4.
#pragma once

#include "kernels/guiding/guide_mixture.h"
#include "kernels/guiding/guide_record.h"

namespace sheaf {

/// Sufficient statistics: sums over the directions so far, weighted by effective sample count and responsibility.
struct alignas(64) GuideSums {
  float count[kGuideLobes] = {};
  float x[kGuideLobes] = {}, y[kGuideLobes] = {}, z[kGuideLobes] = {};  ///< sums of the directions
  float bsdf = 0;                                                       ///< as `count`, for the BSDF
};

/// The initial mixture: even lobes over the hemisphere around `axis`, or over the sphere if `axis` is 0.
GuideMixture first_mixture(Vec3f axis);

/// Updates `mixture` and `sums`, as they were after the last pass, with the records of a pass. Needs at least one
/// record.
void fit_mixture(std::span<const GuideRecord> records, GuideMixture& mixture, GuideSums& sums);

/// Halves the statistics, for the two cells that a split creates.
void halve(GuideSums& sums);

}  // namespace sheaf
