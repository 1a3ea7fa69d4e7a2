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

/// The same for each wavelength.
template <class L> SHEAF_INLINE Spectrum<L> rough_boundary_index(const Spectrum<L>& eta, Float<L> side) {
  return map_spectrum<L>(eta, [side](Float<L> e) SHEAF_LAMBDA_INLINE { return rough_boundary_index<L>(e, side); });
}

/// The index that determines the refracted direction: the only one, or that of the first wavelength.
template <class L> SHEAF_INLINE Float<L> refracting_index(Float<L> ior) { return ior; }
template <class L> SHEAF_INLINE Float<L> refracting_index(const Spectrum<L>& ior) { return ior.c0; }

/// Pdf of visible normals times the Jacobian of reflection or refraction (Walter et al., equations 14 and 17).
template <class L, template <class> class Distribution>
SHEAF_INLINE Float<L> rough_boundary_pdf(const Distribution<L>& facets, Vec3<L> o, Vec3<L> m, Float<L> cos_o,
                                         Float<L> cos_i, Float<L> ior, Mask<L> reflected) {
  using F = Float<L>;
  const F refraction = cos_o * abs(cos_i) * sqr(ior / fma(ior, cos_i, cos_o));
  return facets.density(m) * facets.smith_g1_over_cos(o) * select(reflected, F(0.25f), refraction);
}

/// Reflection and transmission by a facet of a boundary with one index of refraction.
template <class L> struct FacetFresnel {
  using F = Float<L>;
  using Parameters = RoughDielectricParameters<L>;

  const Parameters& boundary;
  F ior;  ///< of the far side over that of the near side
  DielectricFresnel<L> fresnel;
  SpecularChoice<L> choice;

  SHEAF_INLINE FacetFresnel(const Parameters& parameters, F index, F cos_o)
      : boundary(parameters),
        ior(index),
        fresnel(fresnel_dielectric<L>(cos_o, index)),
        choice(fresnel.reflectance, index, parameters.specular, parameters.specular_color) {}

  /// Probability of reflection.
  SHEAF_INLINE F probability() const { return choice.probability; }
  SHEAF_INLINE F cos_transmitted() const { return fresnel.cos_transmitted; }
  /// Probability of the sampled lobe.
  SHEAF_INLINE F chosen(Mask<L> reflected) const {
    return select(reflected, choice.probability, F(1.0f) - choice.probability);
  }
  /// BSDF times cosine. `pdf`: of the facet.
  SHEAF_INLINE Spectrum<L> f_cos(Mask<L> reflected, F pdf, F shadowing) const {
    return weight(reflected, pdf * chosen(reflected) * shadowing);
  }
  /// That divided by the pdf.
  SHEAF_INLINE Spectrum<L> weight(Mask<L> reflected, F shadowing) const {
    const Spectrum<L> tint =
        select<L>(reflected, boundary.reflectance, boundary.transmittance * (F(1.0f) / (ior * ior)));
    return tint * choice.weight(reflected) * shadowing;
  }
};

/// `Distribution`: GgxDistribution or BeckmannDistribution. `Fresnel`: FacetFresnel or DispersiveFacetFresnel.
template <class L, template <class> class Distribution, template <class> class Fresnel>
struct RoughDielectricModel : Fresnel<L>::Parameters {
  static constexpr bool kIsSpecular = false, kIsAnisotropic = true;

  SHEAF_INLINE BsdfValue<L> evaluate(Vec3<L> wo, Vec3<L> wi) const {
    using F = Float<L>;
    const F side = copysign(F(1.0f), wo.z);
    const auto indices = rough_boundary_index<L>(this->eta, side);
    const F ior = refracting_index<L>(indices);
    const Vec3<L> o{wo.x, wo.y, wo.z * side}, i{wi.x, wi.y, wi.z * side};
    const auto reflected = i.z > F(0.0f);
    // Find the normal that reflects or refracts wo into wi.
    const Vec3<L> half = o + i * select(reflected, F(1.0f), ior);
    const Vec3<L> m = normalize(half * copysign(F(1.0f), half.z));
    const F cos_o = dot(o, m), cos_i = dot(i, m);
    const Fresnel<L> fresnel(*this, indices, cos_o);
    const F facet_pdf = rough_boundary_pdf<L>(facets(), o, m, cos_o, cos_i, ior, reflected);
    const F pdf = facet_pdf * fresnel.chosen(reflected);
    const auto valid = (cos_o > F(0.0f)) & select(reflected, cos_i > F(0.0f), cos_i < F(0.0f)) & (pdf > F(0.0f));
    const F shadowing = abs(i.z) * facets().smith_g1_over_cos(i);
    return {select<L>(valid, fresnel.f_cos(reflected, facet_pdf, shadowing), Spectrum<L>(F(0.0f))),
            select(valid, pdf, F(0.0f))};
  }

  SHEAF_INLINE BsdfSample<L> sample(Vec3<L> wo, const Random4<L>& u) const {
    using F = Float<L>;
    const F side = copysign(F(1.0f), wo.z);
    const auto indices = rough_boundary_index<L>(this->eta, side);
    const F ior = refracting_index<L>(indices);
    const Vec3<L> o{wo.x, wo.y, wo.z * side};
    // Sample a visible normal, then reflection or refraction.
    const Vec3<L> m = facets().sample_visible(o, u.y, u.z);
    const F cos_o = min(dot(o, m), F(1.0f));
    const Fresnel<L> fresnel(*this, indices, cos_o);
    const auto reflected = u.x < fresnel.probability();
    const F cos_i = select(reflected, cos_o, fresnel.cos_transmitted());
    const F scale = select(reflected, F(1.0f), F(1.0f) / ior);
    const Vec3<L> i = m * fma(cos_o, scale, cos_i) - o * scale;
    const F pdf = rough_boundary_pdf<L>(facets(), o, m, cos_o, cos_i, ior, reflected) * fresnel.chosen(reflected);
    BsdfSample<L> s;
    s.wi = {i.x, i.y, i.z * side};
    s.weight = fresnel.weight(reflected, abs(i.z) * facets().smith_g1_over_cos(i));
    s.pdf_solid_angle = pdf;
    s.eta_scale = select(reflected, F(1.0f), ior * ior);
    s.valid = (o.z > F(0.0f)) & (cos_o > F(0.0f)) & select(reflected, i.z > F(0.0f), i.z < F(0.0f)) & (pdf > F(0.0f)) &
              is_finite(pdf);
    return s;
  }

  SHEAF_INLINE Float<L> squared_index(Vec3<L> wo) const {
    return sqr(refracting_index<L>(rough_boundary_index<L>(this->eta, copysign(Float<L>(1.0f), wo.z))));
  }

 private:
  SHEAF_INLINE Distribution<L> facets() const { return {this->alpha_u, this->alpha_v}; }
};

template <class L> struct RoughDielectricBeckmannBsdf : RoughDielectricModel<L, BeckmannDistribution, FacetFresnel> {
  using Closure = RoughDielectricBeckmannClosure;
};

template <class L> struct RoughDielectricGgxBsdf : RoughDielectricModel<L, GgxDistribution, FacetFresnel> {
  using Closure = RoughDielectricGgxClosure;
};

template <> struct BsdfOf<RoughDielectricBeckmannClosure> : BsdfTag<RoughDielectricBeckmannBsdf> {};
template <> struct BsdfOf<RoughDielectricGgxClosure> : BsdfTag<RoughDielectricGgxBsdf> {};

}  // namespace sheaf
