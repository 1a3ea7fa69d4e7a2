// PrincipledThinBsdf, compiled once.
#include "kernels/bsdf/principled_thin.h"

namespace sheaf {

template <class L> BsdfValue<L> PrincipledThinBsdf<L>::evaluate(Vec3<L> wo, Vec3<L> wi) const {
  const F side = side_of(wo);
  return evaluate_above(wo * side, wi * side, probabilities(abs(wo.z)));
}

template <class L> BsdfSample<L> PrincipledThinBsdf<L>::sample(Vec3<L> wo, const Random4<L>& u) const {
  const F side = side_of(wo);
  const Vec3<L> o = wo * side;
  const Probabilities p = probabilities(o.z);
  // Choose the lobe
  const Mask<L> specular = u.x < p.specular_reflect + p.specular_transmit;
  const Mask<L> reflects =
      select(specular, u.x < p.specular_reflect, u.x < p.specular_reflect + p.specular_transmit + p.diffuse_reflect);
  // Sample the direction
  const Vec3<L> m = facets(reflects).sample_visible(o, u.y, u.z);
  Vec3<L> wi = select<L>(specular, reflect(o, m), cosine_hemisphere_polar<L>(u.y, u.z));
  const Mask<L> above = wi.z > F(0.0f);
  wi.z = select(reflects, wi.z, -wi.z);
  const Mask<L> leaves_facet = (!specular) | reflects | (dot(wi, m) < F(0.0f));

  return sample_with_value<L>(wi * side, evaluate_above(o, wi, p), above & leaves_facet);
}

template struct PrincipledThinBsdf<Wide>;
template struct PrincipledThinBsdf<Scalar>;

}  // namespace sheaf
