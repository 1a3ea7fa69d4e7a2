// A rough dielectric coat over an opaque closure: CoatedBsdf with microfacet reflection, and with the transmittance of
// the rough coat, averaged over the refracted directions, in place of that of a smooth one (see rough_plastic.h).
// Within the coat directions are those of a smooth one.
#pragma once

#include "kernels/bsdf/coated.h"
#include "kernels/bsdf/microfacet.h"

namespace sheaf {

/// Distribution: GgxDistribution or BeckmannDistribution.
template <class L, template <class> class Distribution> struct RoughCoatedModel : RoughCoatedParameters<L> {
  static constexpr bool kIsSpecular = false, kIsAnisotropic = true;

  SHEAF_INLINE BsdfValue<L> evaluate(Vec3<L> wo, Vec3<L> wi) const {
    const BelowCoat<L> below(*this);
    const Float<L> entering = coat_transmittance(wo.z);
    return evaluate(below, wo, wi, entering, below.coat_probability(wo, entering));
  }

  SHEAF_INLINE BsdfSample<L> sample(Vec3<L> wo, const Random4<L>& u) const {
    using F = Float<L>;
    const BelowCoat<L> below(*this);
    const F entering = coat_transmittance(wo.z), p_coat = below.coat_probability(wo, entering);
    const auto at_coat = u.x < p_coat;
    BsdfSample<L> s = below.sample(wo, below.rest_of(u, p_coat));
    const auto is_mirror = (!at_coat) & (s.pdf_solid_angle == F(0.0f));
    const Vec3<L> m = facets().sample_visible(wo, u.y, u.z);
    s.wi = select<L>(at_coat, m * (F(2.0f) * dot(wo, m)) - wo, s.wi);
    const BsdfValue<L> value = evaluate(below, wo, s.wi, entering, p_coat);
    const auto has_density = value.pdf_solid_angle > F(0.0f);
    s.weight =
        select<L>(is_mirror, s.weight * (entering * coat_transmittance(s.wi.z) / max(F(1.0f) - p_coat, F(1e-20f))),
                  value.f_cos * (F(1.0f) / select(has_density, value.pdf_solid_angle, F(1.0f))));
    s.pdf_solid_angle = select(is_mirror, F(0.0f), value.pdf_solid_angle);
    s.valid = (wo.z > F(0.0f)) & (at_coat | s.valid) & (is_mirror | has_density);
    return s;
  }

 private:
  SHEAF_INLINE Distribution<L> facets() const { return {this->coat_alpha, this->coat_alpha}; }
  SHEAF_INLINE Float<L> coat_transmittance(Float<L> cosine) const {
    return fitted_transmittance<L>(this->transmittance, cosine);
  }

  SHEAF_INLINE BsdfValue<L> evaluate(const BelowCoat<L>& below, Vec3<L> wo, Vec3<L> wi, Float<L> entering,
                                     Float<L> p_coat) const {
    using F = Float<L>;
    const auto top = evaluate_reflection(facets(), wo, wi);
    const F fresnel = fresnel_dielectric<L>(min(top.cos_facet, F(1.0f)), this->coat_eta).reflectance;
    const BsdfValue<L> value = below.evaluate(wo, wi);
    const auto above = (wo.z > F(0.0f)) & (wi.z > F(0.0f));
    const F through = select(above, entering * coat_transmittance(wi.z), F(0.0f));
    return {this->coat_specular * (fresnel * top.pdf_solid_angle * top.shadowing) + value.f_cos * through,
            lerp(p_coat, select(above, value.pdf_solid_angle, F(0.0f)), top.pdf_solid_angle)};
  }
};

template <class L> struct RoughCoatedBeckmannBsdf : RoughCoatedModel<L, BeckmannDistribution> {
  static constexpr auto kKind = ClosureKind::kRoughCoatedBeckmann;
};

template <class L> struct RoughCoatedGgxBsdf : RoughCoatedModel<L, GgxDistribution> {
  static constexpr auto kKind = ClosureKind::kRoughCoatedGgx;
};

}  // namespace sheaf
