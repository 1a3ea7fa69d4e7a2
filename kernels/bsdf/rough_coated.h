// A rough dielectric coat over an opaque closure: CoatedBsdf with microfacet reflection. The coat's transmittance is
// that of the rough interface, averaged over refracted directions (see rough_plastic.h). Directions inside the coat are
// refracted as by a smooth coat.
#pragma once

#include "kernels/bsdf/coated.h"
#include "kernels/bsdf/microfacet.h"
#include "kernels/bsdf/rough_plastic.h"

namespace sheaf {

/// `Distribution`: GgxDistribution or BeckmannDistribution.
template <class L, template <class> class Distribution> struct RoughCoatedModel : RoughCoatedParameters<L> {
  static constexpr bool kIsSpecular = false, kIsAnisotropic = true;

  BsdfValue<L> evaluate(Vec3<L> wo, Vec3<L> wi) const;

  BsdfSample<L> sample(Vec3<L> wo, const Random4<L>& u) const;

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
  using Closure = RoughCoatedBeckmannClosure;
};

template <class L> struct RoughCoatedGgxBsdf : RoughCoatedModel<L, GgxDistribution> {
  using Closure = RoughCoatedGgxClosure;
};

template <> struct BsdfOf<RoughCoatedBeckmannClosure> : BsdfTag<RoughCoatedBeckmannBsdf> {};
template <> struct BsdfOf<RoughCoatedGgxClosure> : BsdfTag<RoughCoatedGgxBsdf> {};

}  // namespace sheaf
