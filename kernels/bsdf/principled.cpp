// PrincipledBsdf, compiled once.
#include "kernels/bsdf/principled.h"

namespace sheaf {

template <class L> BsdfValue<L> PrincipledBsdf<L>::evaluate(Vec3<L> wo, Vec3<L> wi) const {
  const View view(*this, wo);
  return evaluate(view, wi * view.side);
}

template <class L> BsdfSample<L> PrincipledBsdf<L>::sample(Vec3<L> wo, const Random4<L>& u) const {
  const View view(*this, wo);
  const F p_base = view.p_diffuse + view.p_coat;
  // Choose the lobe
  const Mask<L> diffuse = u.x < view.p_diffuse, specular = u.x >= p_base;
  Vec3<L> m = view.facets.sample_visible(view.wo, u.y, u.z);
  const F cos_m = dot(view.wo, m);
  const Facet facet(view, cos_m);
  const Mask<L> refracts =
      specular & ((u.x - p_base) * (facet.reflects + facet.transmits) >= view.p_specular * facet.reflects);
  // Sample the direction
  const Vec3<L> refracted = m * fma(cos_m, view.inverse_eta, -facet.cos_transmitted) - view.wo * view.inverse_eta;
  if (any(view.p_coat > F(0.0f))) m = select<L>(specular, m, view.coat.sample(u.y, u.z));
  const Vec3<L> reflected = reflect(view.wo, m);
  const Vec3<L> wi =
      select<L>(diffuse, cosine_hemisphere_polar<L>(u.y, u.z), select<L>(refracts, refracted, reflected));

  // Evaluate all lobes
  BsdfSample<L> s =
      sample_with_value<L>(wi * view.side, evaluate(view, wi), select(refracts, wi.z<F(0.0f), wi.z> F(0.0f)));
  s.eta_scale = select(refracts, view.eta * view.eta, F(1.0f));
  return s;
}

template struct PrincipledBsdf<Wide>;
template struct PrincipledBsdf<Scalar>;

}  // namespace sheaf
