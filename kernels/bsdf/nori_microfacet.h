// Nori's microfacet BRDF: a Lambertian base of reflectance kd plus a Beckmann lobe of weight ks = 1 - max(kd), with
// dielectric Fresnel reflectance. Shadowing is the rational approximation of Walter et al. 2007 (after equation 27), as
// Nori documents it.
#pragma once

#include "kernels/bsdf/diffuse_base.h"
#include "kernels/bsdf/fresnel.h"
#include "kernels/bsdf/microfacet.h"
#include "scene/materials/nori_microfacet.h"

namespace sheaf {

template <class L> struct NoriMicrofacetBsdf : NoriMicrofacetParameters<L> {
  using Closure = NoriMicrofacetClosure;
  static constexpr bool kIsSpecular = false, kIsAnisotropic = false;

  SHEAF_INLINE BsdfValue<L> evaluate(Vec3<L> wo, Vec3<L> wi) const {
    using F = Float<L>;
    const BeckmannDistribution<L> facets(this->alpha, this->alpha);
    const Vec3<L> m = normalize(wo + wi);
    const F density = F(0.25f) * facets.density(m), ks = specular_weight();
    const F facet_pdf = density * facets.smith_g1_over_cos(wo), cosine_pdf = cosine_hemisphere_pdf_solid_angle(wi.z);
    const F fresnel = fresnel_dielectric<L>(clamp(dot(wo, m), F(0.0f), F(1.0f)), this->eta).reflectance;
    const F mirrored = ks * fresnel * density * shadowing_over_cos(wo) * shadowing_over_cos(wi) * wi.z;
    const auto above = (wo.z > F(0.0f)) & (wi.z > F(0.0f));
    const auto facing = above & (facet_pdf > F(0.0f));
    const Spectrum<L> f = this->kd * cosine_pdf + Spectrum<L>(select(facing, mirrored, F(0.0f)));
    const F pdf = lerp(ks, cosine_pdf, select(facing, facet_pdf, F(0.0f)));
    return {select<L>(above, f, Spectrum<L>(F(0.0f))), select(above, pdf, F(0.0f))};
  }

  SHEAF_INLINE BsdfSample<L> sample(Vec3<L> wo, const Random4<L>& u) const {
    const BeckmannDistribution<L> facets(this->alpha, this->alpha);
    const Vec3<L> mirrored = reflect(wo, facets.sample_visible(wo, u.y, u.z));
    return sample_specular_or_diffuse<L>(mirrored, specular_weight(), u,
                                         [&](Vec3<L> wi) SHEAF_LAMBDA_INLINE { return evaluate(wo, wi); });
  }

 private:
  /// ks; also the probability of sampling the Beckmann lobe.
  SHEAF_INLINE Float<L> specular_weight() const {
    return clamp(Float<L>(1.0f) - max_component(this->kd), Float<L>(0.0f), Float<L>(1.0f));
  }

  /// The rational approximation of G1, divided by the cosine; finite at grazing directions.
  SHEAF_INLINE Float<L> shadowing_over_cos(Vec3<L> v) const {
    using F = Float<L>;
    const F z = abs(v.z), s = this->alpha * safe_sqrt(F(1.0f) - z * z);
    // With b = z / s: (3.535 b + 2.181 b^2) / (1 + 2.276 b + 2.577 b^2) for b < 1.6, extended by s^2 / s^2.
    const F rational = fma(F(3.535f), s, F(2.181f) * z) / (s * s + z * fma(F(2.276f), s, F(2.577f) * z));
    return select(z < F(1.6f) * s, rational, F(1.0f) / z);
  }
};

template <> struct BsdfOf<NoriMicrofacetClosure> : BsdfTag<NoriMicrofacetBsdf> {};

}  // namespace sheaf
