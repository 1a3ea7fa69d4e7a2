// MetallicRoughnessBsdf, compiled once.
#include "kernels/bsdf/metallic_roughness.h"

namespace sheaf {

template <class L> BsdfValue<L> MetallicRoughnessBsdf<L>::evaluate(Vec3<L> wo, Vec3<L> wi) const {
  const View view(*this, wo);
  return evaluate(view, view.to_local(wi));
}

template <class L> BsdfSample<L> MetallicRoughnessBsdf<L>::sample(Vec3<L> wo, const Random4<L>& u) const {
  const F zero(0.0f), one(1.0f);
  const View view(*this, wo);
  // Choose the lobe
  const F after_transmit = view.p_diffuse + view.p_transmit, after_coat = after_transmit + view.p_coat;
  const Mask<L> diffuse = u.x < view.p_diffuse;
  const Mask<L> transmits = (u.x >= view.p_diffuse) & (u.x < after_transmit);
  const Mask<L> coat = (u.x >= after_transmit) & (u.x < after_coat);
  const Mask<L> sheen = (u.x >= after_coat) & (u.x < after_coat + view.p_sheen);

  // Sample the direction
  GgxDistribution<L> facets = view.lobe.facets;
  if (any(coat)) {
    const F alpha = alpha_of(this->clearcoat_roughness);
    facets = {select(coat, alpha, facets.alpha_u), select(coat, alpha, facets.alpha_v)};
  }
  Vec3<L> wi = reflect(view.wo, facets.sample_visible(view.wo, u.y, u.z));
  wi = select<L>(diffuse, cosine_hemisphere_polar<L>(u.y, u.z), wi);
  if (any(sheen)) {
    // Uniform over the hemisphere
    const F z = one - u.z, r = safe_sqrt(fma(-z, z, one));
    const auto angle = sincos_2pi<L>(u.y);
    wi = select<L>(sheen, Vec3<L>{r * angle.cos, r * angle.sin, z}, wi);
  }
  const Mask<L> above = wi.z > zero;
  wi.z = select(transmits, -wi.z, wi.z);

  // Evaluate all lobes
  return sample_with_value<L>(view.to_shading_frame(wi), evaluate(view, wi), above);
}

template struct MetallicRoughnessBsdf<Wide>;
template struct MetallicRoughnessBsdf<Scalar>;

}  // namespace sheaf
