// A diffuse base under a rough dielectric coat: PlasticBsdf with microfacet reflection. The coat's transmittance is
// that of the rough interface, averaged over refracted directions.
//
// The transmittance T is a polynomial fit: T = t1 + t2 y + ... + t7 y^6 with y = (1 + t0) cos / (cos + t0). t0 widens
// the range near grazing directions in which T rises. scene/materials/rough_coat.cpp computes the fit.
#pragma once

#include "kernels/bsdf/diffuse_base.h"
#include "kernels/bsdf/microfacet.h"
#include "kernels/bsdf/plastic.h"

namespace sheaf {

/// Transmittance of a rough coat into the surface, for a direction at this cosine; evaluates the fit.
template <class L>
SHEAF_INLINE Float<L> fitted_transmittance(const Float<L> (&t)[kTransmittanceTerms], Float<L> cosine) {
  using F = Float<L>;
  const F c = abs(cosine), y = (F(1.0f) + t[0]) * c / (c + t[0]);
  F sum = t[kTransmittanceTerms - 1];
  for (int i = kTransmittanceTerms - 2; i > 0; --i) sum = fma(sum, y, t[i]);
  return clamp(sum, F(0.0f), F(1.0f));
}

/// `Distribution`: GgxDistribution or BeckmannDistribution.
template <class L, template <class> class Distribution> struct RoughPlasticModel : RoughPlasticParameters<L> {
  static constexpr bool kIsSpecular = false, kIsAnisotropic = false;

  SHEAF_INLINE BsdfValue<L> evaluate(Vec3<L> wo, Vec3<L> wi) const {
    const Float<L> entering = coat_transmittance(wo.z);
    return evaluate(wo, wi, entering, probability(entering));
  }

  SHEAF_INLINE BsdfSample<L> sample(Vec3<L> wo, const Random4<L>& u) const {
    using F = Float<L>;
    const F entering = coat_transmittance(wo.z), coat_probability = probability(entering);
    const Vec3<L> mirrored = reflect(wo, facets().sample_visible(wo, u.y, u.z));
    return sample_specular_or_diffuse<L>(mirrored, coat_probability, u, [&](Vec3<L> wi) SHEAF_LAMBDA_INLINE {
      return evaluate(wo, wi, entering, coat_probability);
    });
  }

 private:
  SHEAF_INLINE Distribution<L> facets() const { return {this->alpha, this->alpha}; }

  SHEAF_INLINE Float<L> coat_transmittance(Float<L> cosine) const {
    return fitted_transmittance<L>(this->transmittance, cosine);
  }

  SHEAF_INLINE Float<L> probability(Float<L> entering) const {
    return coat_probability<L>(Float<L>(1.0f) - entering, this->specular, this->diffuse);
  }

  /// `entering`: coat_transmittance(wo.z); `coat_probability`: probability of sampling the specular lobe.
  SHEAF_INLINE BsdfValue<L> evaluate(Vec3<L> wo, Vec3<L> wi, Float<L> entering, Float<L> coat_probability) const {
    using F = Float<L>;
    const auto coat = evaluate_reflection(facets(), wo, wi);
    const F fresnel = fresnel_dielectric<L>(min(coat.cos_facet, F(1.0f)), this->eta).reflectance;
    const F cosine_pdf = select(wo.z > F(0.0f), cosine_hemisphere_pdf_solid_angle(wi.z), F(0.0f));
    const Spectrum<L> base = coated_albedo<L>(this->diffuse, this->internal_reflectance, this->nonlinear, this->eta);
    return {this->specular * (fresnel * coat.pdf_solid_angle * coat.shadowing) +
                base * (entering * coat_transmittance(wi.z) * cosine_pdf),
            lerp(coat_probability, cosine_pdf, coat.pdf_solid_angle)};
  }
};

template <class L> struct RoughPlasticBeckmannBsdf : RoughPlasticModel<L, BeckmannDistribution> {
  using Closure = RoughPlasticBeckmannClosure;
};

template <class L> struct RoughPlasticGgxBsdf : RoughPlasticModel<L, GgxDistribution> {
  using Closure = RoughPlasticGgxClosure;
};

template <> struct BsdfOf<RoughPlasticBeckmannClosure> : BsdfTag<RoughPlasticBeckmannBsdf> {};
template <> struct BsdfOf<RoughPlasticGgxClosure> : BsdfTag<RoughPlasticGgxBsdf> {};

}  // namespace sheaf
