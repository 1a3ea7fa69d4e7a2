// CoatedBsdf, compiled once.
#include "kernels/bsdf/coated.h"

namespace sheaf {

template <class L> BsdfValue<L> BelowCoat<L>::evaluate(Vec3<L> wo, Vec3<L> wi) const {
  const Vec3<L> o = bent(wo, inverse_eta), i = bent(wi, inverse_eta);
  const BsdfValue<L> value = evaluate_nested<L>(coat, o, i);
  // Jacobian of solid angle, and of cosine times solid angle, from outside to inside; f_cos includes both cosines.
  const F compression = sqr(inverse_eta) * wi.z / max(i.z, F(1e-6f));
  return {value.f_cos * absorption(o.z, i.z) * compression, value.pdf_solid_angle * compression};
}

template <class L> BsdfSample<L> BelowCoat<L>::sample(Vec3<L> wo, const Random4<L>& u) const {
  const Vec3<L> o = bent(wo, inverse_eta);
  BsdfSample<L> s = sample_nested<L>(coat, o, u);
  s.weight = s.weight * absorption(o.z, s.wi.z);
  s.wi = bent(s.wi, coat.coat_eta);
  s.valid = s.valid & (s.wi.z > F(0.0f));
  return s;
}

template <class L> BsdfValue<L> CoatedBsdf<L>::evaluate(Vec3<L> wo, Vec3<L> wi) const {
  const BelowCoat<L> below(*this);
  const Float<L> entering = coat_transmittance(wo.z);
  return evaluate(below, wo, wi, entering, below.coat_probability(wo, entering));
}

template <class L> BsdfSample<L> CoatedBsdf<L>::sample(Vec3<L> wo, const Random4<L>& u) const {
  using F = Float<L>;
  const BelowCoat<L> below(*this);
  const F entering = coat_transmittance(wo.z), p_coat = below.coat_probability(wo, entering);
  // Choose between the coat and the base.
  const auto at_coat = u.x < p_coat;
  BsdfSample<L> s = below.sample(wo, below.rest_of(u, p_coat));
  const auto is_mirror = at_coat | (s.pdf_solid_angle == F(0.0f));
  s.wi = select<L>(at_coat, {-wo.x, -wo.y, wo.z}, s.wi);
  const BsdfValue<L> value = evaluate(below, wo, s.wi, entering, p_coat);
  const Spectrum<L> nested = s.weight * (entering * coat_transmittance(s.wi.z) / max(F(1.0f) - p_coat, F(1e-20f)));
  const auto has_density = value.pdf_solid_angle > F(0.0f);
  s.weight = select<L>(at_coat, this->coat_specular * ((F(1.0f) - entering) / max(p_coat, F(1e-20f))), nested);
  s.weight =
      select<L>(is_mirror, s.weight, value.f_cos * (F(1.0f) / select(has_density, value.pdf_solid_angle, F(1.0f))));
  s.pdf_solid_angle = select(is_mirror, F(0.0f), value.pdf_solid_angle);
  s.valid = (wo.z > F(0.0f)) & (at_coat | (s.valid & (is_mirror | has_density)));
  return s;
}

template struct BelowCoat<Wide>;
template struct BelowCoat<Scalar>;
template struct CoatedBsdf<Wide>;
template struct CoatedBsdf<Scalar>;

}  // namespace sheaf
