// Rough coats, compiled once.
#include "kernels/bsdf/rough_coated.h"

namespace sheaf {

template <class L, template <class> class Distribution>
BsdfValue<L> RoughCoatedModel<L, Distribution>::evaluate(Vec3<L> wo, Vec3<L> wi) const {
  const BelowCoat<L> below(*this);
  const Float<L> entering = coat_transmittance(wo.z);
  return evaluate(below, wo, wi, entering, below.coat_probability(wo, entering));
}

template <class L, template <class> class Distribution>
BsdfSample<L> RoughCoatedModel<L, Distribution>::sample(Vec3<L> wo, const Random4<L>& u) const {
  using F = Float<L>;
  const BelowCoat<L> below(*this);
  const F entering = coat_transmittance(wo.z), p_coat = below.coat_probability(wo, entering);
  const auto at_coat = u.x < p_coat;
  BsdfSample<L> s = below.sample(wo, below.rest_of(u, p_coat));
  const auto is_mirror = (!at_coat) & (s.pdf_solid_angle == F(0.0f));
  const Vec3<L> m = facets().sample_visible(wo, u.y, u.z);
  s.wi = select<L>(at_coat, reflect(wo, m), s.wi);
  const BsdfValue<L> value = evaluate(below, wo, s.wi, entering, p_coat);
  const auto has_density = value.pdf_solid_angle > F(0.0f);
  s.weight = select<L>(is_mirror, s.weight * (entering * coat_transmittance(s.wi.z) / max(F(1.0f) - p_coat, F(1e-20f))),
                       value.f_cos * (F(1.0f) / select(has_density, value.pdf_solid_angle, F(1.0f))));
  s.pdf_solid_angle = select(is_mirror, F(0.0f), value.pdf_solid_angle);
  s.valid = (wo.z > F(0.0f)) & (at_coat | s.valid) & (is_mirror | has_density);
  return s;
}

template struct RoughCoatedModel<Wide, BeckmannDistribution>;
template struct RoughCoatedModel<Scalar, BeckmannDistribution>;
template struct RoughCoatedModel<Wide, GgxDistribution>;
template struct RoughCoatedModel<Scalar, GgxDistribution>;

}  // namespace sheaf
