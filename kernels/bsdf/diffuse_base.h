// Parts of BRDFs that consist of a specular lobe over a diffuse base.
#pragma once

#include "core/sampling/warp.h"
#include "kernels/bsdf/bsdf.h"

namespace sheaf {

/// Probability of sampling the specular lobe, by the reflectances of both lobes.
template <class L> SHEAF_INLINE Float<L> lobe_probability(Spectrum<L> specular, Spectrum<L> diffuse) {
  using F = Float<L>;
  const F glossy = total(specular), all = glossy + total(diffuse);
  return select(all > F(0.0f), glossy / max(all, F(1e-30f)), F(0.5f));
}

/// Samples the specular lobe with `probability`, otherwise the diffuse base. `specular`: direction sampled from the
/// specular lobe by u.y and u.z; evaluate(wi): value of both lobes.
template <class L, class Evaluate>
SHEAF_INLINE BsdfSample<L> sample_specular_or_diffuse(Vec3<L> specular, Float<L> probability, const Random4<L>& u,
                                                      Evaluate&& evaluate) {
  const Vec3<L> wi = select<L>(u.x < probability, specular, square_to_cosine_hemisphere<L>(u.y, u.z));
  return sample_with_value<L>(wi, evaluate(wi));
}

}  // namespace sheaf
