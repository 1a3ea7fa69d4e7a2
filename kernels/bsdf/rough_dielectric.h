// A rough dielectric boundary (Walter et al., "Microfacet Models for Refraction through Rough Surfaces", EGSR 2007).
// Sampling picks a visible normal, then reflects or refracts with its Fresnel reflectance as the probability. Multiple
// scattering between facets is lost. Radiance that enters a medium is scaled by the squared relative index.
//
// If wo lies below the surface, both directions are mirrored at the surface and the relative index is inverted.
#pragma once

#include "kernels/bsdf/bsdf.h"
#include "kernels/bsdf/microfacet.h"
#include "kernels/bsdf/specular_scale.h"
#include "scene/materials/dielectric.h"

namespace sheaf {

/// Minimum of |eta - 1|: refraction by microfacets has no solid-angle pdf if the index does not change. Smaller steps
/// are replaced by this one. DielectricBsdf suits a matched boundary better.
inline constexpr float kMinIndexStep = 1e-3f;

/// Index of the far side over that of the near side. `eta`: inside over outside; `side`: sign of wo.z.
template <class L> SHEAF_INLINE Float<L> rough_boundary_index(Float<L> eta, Float<L> side) {
  using F = Float<L>;
  const F ior = select(abs(eta - F(1.0f)) < F(kMinIndexStep), F(1.0f + kMinIndexStep), eta);
  return select(side > F(0.0f), ior, F(1.0f) / ior);
}

/// Pdf of visible normals times the Jacobian of reflection or refraction (Walter et al., equations 14 and 17).
template <class L, template <class> class Distribution>
SHEAF_INLINE Float<L> rough_boundary_pdf(const Distribution<L>& facets, Vec3<L> o, Vec3<L> m, Float<L> cos_o,
                                         Float<L> cos_i, Float<L> ior, Mask<L> reflected) {
  using F = Float<L>;
  const F refraction = cos_o * abs(cos_i) * sqr(ior / fma(ior, cos_i, cos_o));
  return facets.density(m) * facets.smith_g1_over_cos(o) * select(reflected, F(0.25f), refraction);
}

/// `Distribution`: GgxDistribution or BeckmannDistribution.
template <class L, template <class> class Distribution> struct RoughDielectricModel : RoughDielectricParameters<L> {
  static constexpr bool kIsSpecular = false, kIsAnisotropic = true;

  SHEAF_INLINE BsdfValue<L> evaluate(Vec3<L> wo, Vec3<L> wi) const {
    using F = Float<L>;
    const F side = copysign(F(1.0f), wo.z), ior = relative_index(side);
    const Vec3<L> o{wo.x, wo.y, wo.z * side}, i{wi.x, wi.y, wi.z * side};
    const auto reflected = i.z > F(0.0f);
    // Find the normal that reflects or refracts wo into wi.
    const Vec3<L> half = o + i * select(reflected, F(1.0f), ior);
    const Vec3<L> m = normalize(half * copysign(F(1.0f), half.z));
    const F cos_o = dot(o, m), cos_i = dot(i, m);
    const SpecularChoice<L> choice = choice_at(fresnel_dielectric<L>(cos_o, ior).reflectance, ior);
    const F share = choice.probability;
    const F pdf = pdf_solid_angle(o, m, cos_o, cos_i, ior, reflected) * select(reflected, share, F(1.0f) - share);
    const auto valid = (cos_o > F(0.0f)) & select(reflected, cos_i > F(0.0f), cos_i < F(0.0f)) & (pdf > F(0.0f));
    const F shadowing = abs(i.z) * facets().smith_g1_over_cos(i);
    return {select<L>(valid, tint(reflected, ior) * choice.weight(reflected) * (pdf * shadowing), Spectrum<L>(F(0.0f))),
            select(valid, pdf, F(0.0f))};
  }

  SHEAF_INLINE BsdfSample<L> sample(Vec3<L> wo, const Random4<L>& u) const {
    using F = Float<L>;
    const F side = copysign(F(1.0f), wo.z), ior = relative_index(side), inverse_ior = F(1.0f) / ior;
    const Vec3<L> o{wo.x, wo.y, wo.z * side};
    // Sample a visible normal, then reflection or refraction.
    const Vec3<L> m = facets().sample_visible(o, u.y, u.z);
    const F cos_o = min(dot(o, m), F(1.0f));
    const auto fresnel = fresnel_dielectric<L>(cos_o, ior);
    const SpecularChoice<L> choice = choice_at(fresnel.reflectance, ior);
    const auto reflected = u.x < choice.probability;
    const F cos_i = select(reflected, cos_o, fresnel.cos_transmitted);
    const F scale = select(reflected, F(1.0f), inverse_ior);
    const Vec3<L> i = m * fma(cos_o, scale, cos_i) - o * scale;
    const F pdf = pdf_solid_angle(o, m, cos_o, cos_i, ior, reflected) *
                  select(reflected, choice.probability, F(1.0f) - choice.probability);
    BsdfSample<L> s;
    s.wi = {i.x, i.y, i.z * side};
    s.weight = tint(reflected, ior) * choice.weight(reflected) * (abs(i.z) * facets().smith_g1_over_cos(i));
    s.pdf_solid_angle = pdf;
    s.eta_scale = select(reflected, F(1.0f), ior * ior);
    s.valid = (o.z > F(0.0f)) & (cos_o > F(0.0f)) & select(reflected, i.z > F(0.0f), i.z < F(0.0f)) & (pdf > F(0.0f)) &
              is_finite(pdf);
    return s;
  }

  SHEAF_INLINE Float<L> squared_index(Vec3<L> wo) const { return sqr(relative_index(copysign(Float<L>(1.0f), wo.z))); }

 private:
  SHEAF_INLINE Distribution<L> facets() const { return {this->alpha_u, this->alpha_v}; }

  SHEAF_INLINE SpecularChoice<L> choice_at(Float<L> fresnel, Float<L> ior) const {
    return {fresnel, ior, this->specular, this->specular_color};
  }

  SHEAF_INLINE Float<L> relative_index(Float<L> side) const { return rough_boundary_index<L>(this->eta, side); }

  SHEAF_INLINE Float<L> pdf_solid_angle(Vec3<L> o, Vec3<L> m, Float<L> cos_o, Float<L> cos_i, Float<L> ior,
                                        Mask<L> reflected) const {
    return rough_boundary_pdf<L>(facets(), o, m, cos_o, cos_i, ior, reflected);
  }

  SHEAF_INLINE Spectrum<L> tint(Mask<L> reflected, Float<L> ior) const {
    return select<L>(reflected, this->reflectance, this->transmittance * (Float<L>(1.0f) / (ior * ior)));
  }
};

template <class L> struct RoughDielectricBeckmannBsdf : RoughDielectricModel<L, BeckmannDistribution> {
  using Closure = RoughDielectricBeckmannClosure;
};

template <class L> struct RoughDielectricGgxBsdf : RoughDielectricModel<L, GgxDistribution> {
  using Closure = RoughDielectricGgxClosure;
};

template <> struct BsdfOf<RoughDielectricBeckmannClosure> : BsdfTag<RoughDielectricBeckmannBsdf> {};
template <> struct BsdfOf<RoughDielectricGgxClosure> : BsdfTag<RoughDielectricGgxBsdf> {};

}  // namespace sheaf
