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
  // Choose the lobe.
  const Mask<L> specular = u.x < p.specular_reflect + p.specular_transmit;
  const Mask<L> reflects =
      select(specular, u.x < p.specular_reflect, u.x < p.specular_reflect + p.specular_transmit + p.diffuse_reflect);
  // Sample the direction.
  const Vec3<L> m = facets(reflects).sample_visible(o, u.y, u.z);
  Vec3<L> wi = select<L>(specular, m * (F(2.0f) * dot(o, m)) - o, cosine_hemisphere_polar<L>(u.y, u.z));
  const Mask<L> above = wi.z > F(0.0f);
  wi.z = select(reflects, wi.z, -wi.z);
  const Mask<L> leaves_facet = (!specular) | reflects | (dot(wi, m) < F(0.0f));

  const BsdfValue<L> value = evaluate_above(o, wi, p);
  BsdfSample<L> s;
  s.wi = wi * side;
  s.pdf_solid_angle = value.pdf_solid_angle;
  s.valid = above & leaves_facet & (value.pdf_solid_angle > F(0.0f));
  s.weight = value.f_cos * (F(1.0f) / select(s.valid, value.pdf_solid_angle, F(1.0f)));
  s.eta_scale = F(1.0f);
  return s;
}

template struct PrincipledThinBsdf<Wide>;
template struct PrincipledThinBsdf<Scalar>;

}  // namespace sheaf
