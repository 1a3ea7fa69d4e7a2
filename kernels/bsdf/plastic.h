// A diffuse base under a smooth dielectric coat. The coat reflects light specularly, or transmits it to the base, which
// scatters it back out. Light that the coat reflects back inside returns to the base; the geometric series of these
// reflections has a closed form. Pharr et al. 2023, section 14.3, describe such coats; the closed form is that of
// Mitsuba's "plastic".
#pragma once

#include "core/sampling/warp.h"
#include "kernels/bsdf/bsdf.h"
#include "kernels/bsdf/fresnel.h"
#include "scene/materials/plastic.h"

namespace sheaf {

/// Diffuse albedo of a base under a coat, without the coat's transmittance on entry and exit: albedo / (eta^2 (1 -
/// internal_reflectance c)), where c is the albedo if `nonlinear`, and otherwise 1.
template <class L>
SHEAF_INLINE Spectrum<L> coated_albedo(Spectrum<L> albedo, Float<L> internal_reflectance, Uint<L> nonlinear,
                                       Float<L> eta) {
  using F = Float<L>;
  const F weight = select(nonlinear != Uint<L>(0u), F(1.0f), F(0.0f));
  const F inverse_eta2 = F(1.0f) / (eta * eta);
  return map_spectrum<L>(albedo, [&](F a) SHEAF_LAMBDA_INLINE {
    // A base of albedo 1 under a coat with total internal reflection would be 0 / 0.
    const F loss = F(1.0f) - internal_reflectance * lerp(weight, F(1.0f), a);
    return a * inverse_eta2 / max(loss, F(1e-6f));
  });
}

/// Probability of sampling the specular lobe of a coat with Fresnel reflectance `reflected`. Proportional to what each
/// lobe scatters, by its largest component.
template <class L>
SHEAF_INLINE Float<L> coat_probability(Float<L> reflected, Spectrum<L> specular, Spectrum<L> diffuse) {
  using F = Float<L>;
  const F coat = reflected * max_component(specular), base = (F(1.0f) - reflected) * max_component(diffuse);
  return select(coat + base > F(0.0f), coat / max(coat + base, F(1e-30f)), F(0.5f));
}

template <class L> struct PlasticBsdf : PlasticParameters<L> {
  using Closure = PlasticClosure;
  static constexpr bool kIsSpecular = false, kIsAnisotropic = false;

  SHEAF_INLINE BsdfValue<L> evaluate(Vec3<L> wo, Vec3<L> wi) const {
    using F = Float<L>;
    const F reflected = coat_reflectance(wo.z);
    const F cosine_pdf = select(wo.z > F(0.0f), cosine_hemisphere_pdf_solid_angle(wi.z), F(0.0f));
    return {base(reflected, wi.z) * cosine_pdf, cosine_pdf * (F(1.0f) - probability(reflected))};
  }

  SHEAF_INLINE BsdfSample<L> sample(Vec3<L> wo, const Random4<L>& u) const {
    using F = Float<L>;
    const F reflected = coat_reflectance(wo.z), p_coat = probability(reflected), p_base = F(1.0f) - p_coat;
    const auto at_coat = u.x < p_coat;
    const Vec3<L> diffuse_wi = square_to_cosine_hemisphere<L>(u.y, u.z);
    BsdfSample<L> s;
    s.wi = select<L>(at_coat, {-wo.x, -wo.y, wo.z}, diffuse_wi);
    s.weight =
        select<L>(at_coat, this->specular * (reflected / p_coat), base(reflected, diffuse_wi.z) * (F(1.0f) / p_base));
    s.pdf_solid_angle = select(at_coat, F(0.0f), cosine_hemisphere_pdf_solid_angle(diffuse_wi.z) * p_base);
    s.eta_scale = F(1.0f);
    s.valid = (wo.z > F(0.0f)) & (s.wi.z > F(0.0f));
    return s;
  }

 private:
  SHEAF_INLINE Float<L> coat_reflectance(Float<L> cosine) const {
    return fresnel_dielectric<L>(abs(cosine), this->eta).reflectance;
  }
  SHEAF_INLINE Float<L> probability(Float<L> reflected) const {
    return coat_probability<L>(reflected, this->specular, this->diffuse);
  }
  /// Albedo of the diffuse lobe for incident light at cosine `cos_i`; `reflected`: coat_reflectance(wo.z).
  SHEAF_INLINE Spectrum<L> base(Float<L> reflected, Float<L> cos_i) const {
    const Float<L> through = (Float<L>(1.0f) - reflected) * (Float<L>(1.0f) - coat_reflectance(cos_i));
    return coated_albedo<L>(this->diffuse, this->internal_reflectance, this->nonlinear, this->eta) * through;
  }
};

template <> struct BsdfOf<PlasticClosure> : BsdfTag<PlasticBsdf> {};

}  // namespace sheaf
