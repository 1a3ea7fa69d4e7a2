// Fitting a guide's mixture to directions from which light came.
//
// What paths sample at a vertex is a p_b + (1 - a) sum_k s_k v_k: BSDF and lobes together. By expectation maximisation
// over directions weighted by the light that they brought over their density, that mixture comes as near to being
// proportional to the integrand as it can, by the Kullback-Leibler divergence, which is what Mueller ("Practical Path
// Guiding in Production", 2019) learns the share `a` by. The BSDF is one component among the others here, whose shape
// is given: lobes learn what it leaves over, and its share needs no rate of learning.
//
// Sums over directions are kept from one training pass to the next with less and less weight, and are those of
// effective samples, so that what few bright paths have found counts as few samples; priors as in Ruppert, Herholz and
// Lensch 2020, section 4.
#pragma once

#include "kernels/guiding/guide_mixture.h"
#include "kernels/guiding/guide_record.h"

namespace sheaf {

/// Sums over the directions seen so far, each weighted by its effective number and by how far it belongs to a lobe.
struct alignas(64) GuideSums {
  float count[kGuideLobes] = {};
  float x[kGuideLobes] = {}, y[kGuideLobes] = {}, z[kGuideLobes] = {};  ///< of the directions themselves
  float bsdf = 0;                                                       ///< the same as `count` for the BSDF
};

/// A mixture that knows nothing: even lobes over the half of the directions around `axis`, or all of them if it is 0.
GuideMixture first_mixture(Vec3f axis);

/// Fits `mixture` and `sums`, what both were after the last pass, to a pass's records, at least one.
void fit_mixture(std::span<const GuideRecord> records, GuideMixture& mixture, GuideSums& sums);

/// What one half of a place knows at first when it is split.
void halve(GuideSums& sums);

}  // namespace sheaf
