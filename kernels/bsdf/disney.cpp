// DisneyBsdf, compiled once.
#include "kernels/bsdf/disney.h"

namespace sheaf {

template <class L> BsdfValue<L> DisneyBsdf<L>::evaluate(Vec3<L> wo, Vec3<L> wi) const {
  return evaluate(View(*this, wo), wi);
}

template <class L> BsdfSample<L> DisneyBsdf<L>::sample(Vec3<L> wo, const Random4<L>& u) const {
  const View view(*this, wo);
  const Mask<L> diffuse = u.x < view.p_diffuse;
  Vec3<L> m = view.facets.sample_visible({wo.x, wo.y, abs(wo.z)}, u.y, u.z);
  if (any(view.p_coat > F(0.0f))) m = select<L>(u.x < view.p_diffuse + view.p_coat, view.coat.sample(u.y, u.z), m);
  const Vec3<L> wi = select<L>(diffuse, cosine_hemisphere_polar<L>(u.y, u.z), reflect(wo, m));
  return sample_with_value<L>(wi, evaluate(view, wi));
}

template struct DisneyBsdf<Wide>;
template struct DisneyBsdf<Scalar>;

}  // namespace sheaf
