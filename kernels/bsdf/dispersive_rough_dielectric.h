// A rough dielectric boundary whose index of refraction depends on the wavelength: RoughDielectricModel of spectral
// mode. Refraction keeps the first wavelength only, in both evaluation and sampling, so that light sampling and BSDF
// sampling estimate the same integral; see dispersive_dielectric.h.
#pragma once

#include "kernels/bsdf/dispersive_dielectric.h"
#include "kernels/bsdf/rough_dielectric.h"

namespace sheaf {

/// `Distribution`: GgxDistribution or BeckmannDistribution.
template <class L, template <class> class Distribution>
struct DispersiveRoughDielectricModel : DispersiveRoughDielectricParameters<L> {
  static constexpr bool kIsSpecular = false, kIsAnisotropic = true, kDisperses = true;

  SHEAF_INLINE BsdfValue<L> evaluate(Vec3<L> wo, Vec3<L> wi) const {
    using F = Float<L>;
    const F side = copysign(F(1.0f), wo.z);
    const Spectrum<L> ior = relative_indices(side);
    const Vec3<L> o{wo.x, wo.y, wo.z * side}, i{wi.x, wi.y, wi.z * side};
    const auto reflected = i.z > F(0.0f);
    const Vec3<L> half = o + i * select(reflected, F(1.0f), ior.c0);
    const Vec3<L> m = normalize(half * copysign(F(1.0f), half.z));
    const F cos_o = dot(o, m), cos_i = dot(i, m);
    const auto f = fresnel_dispersive<L>(cos_o, ior, this->specular, this->specular_color);
    const F facet_pdf = rough_boundary_pdf<L>(facets(), o, m, cos_o, cos_i, ior.c0, reflected);
    const F pdf = facet_pdf * choice(f, reflected);
    const auto valid = (cos_o > F(0.0f)) & select(reflected, cos_i > F(0.0f), cos_i < F(0.0f)) & (facet_pdf > F(0.0f));
    const F shadowing = abs(i.z) * facets().smith_g1_over_cos(i);
    return {select<L>(valid, scattered(f, reflected) * (facet_pdf * shadowing), Spectrum<L>(F(0.0f))),
            select(valid, pdf, F(0.0f))};
  }

  SHEAF_INLINE BsdfSample<L> sample(Vec3<L> wo, const Random4<L>& u) const {
    using F = Float<L>;
    const F side = copysign(F(1.0f), wo.z);
    const Spectrum<L> ior = relative_indices(side);
    const Vec3<L> o{wo.x, wo.y, wo.z * side};
    // Sample a visible normal, then reflection or refraction.
    const Vec3<L> m = facets().sample_visible(o, u.y, u.z);
    const F cos_o = min(dot(o, m), F(1.0f));
    const auto f = fresnel_dispersive<L>(cos_o, ior, this->specular, this->specular_color);
    const auto reflected = u.x < f.probability;
    const F cos_i = select(reflected, cos_o, f.first.cos_transmitted);
    const F scale = select(reflected, F(1.0f), F(1.0f) / ior.c0);
    const Vec3<L> i = m * fma(cos_o, scale, cos_i) - o * scale;
    BsdfSample<L> s;
    s.wi = {i.x, i.y, i.z * side};
    s.pdf_solid_angle = rough_boundary_pdf<L>(facets(), o, m, cos_o, cos_i, ior.c0, reflected) * choice(f, reflected);
    s.weight = scattered(f, reflected) * (abs(i.z) * facets().smith_g1_over_cos(i) / choice(f, reflected));
    s.eta_scale = select(reflected, F(1.0f), ior.c0 * ior.c0);
    s.valid = (o.z > F(0.0f)) & (cos_o > F(0.0f)) & select(reflected, i.z > F(0.0f), i.z < F(0.0f)) &
              (s.pdf_solid_angle > F(0.0f)) & is_finite(s.pdf_solid_angle);
    return s;
  }

  SHEAF_INLINE Float<L> squared_index(Vec3<L> wo) const {
    return sqr(rough_boundary_index<L>(this->eta.c0, copysign(Float<L>(1.0f), wo.z)));
  }

 private:
  SHEAF_INLINE Distribution<L> facets() const { return {this->alpha_u, this->alpha_v}; }

  /// Indices of the far side relative to the near side.
  SHEAF_INLINE Spectrum<L> relative_indices(Float<L> side) const {
    return map_spectrum<L>(this->eta,
                           [side](Float<L> index) SHEAF_LAMBDA_INLINE { return rough_boundary_index<L>(index, side); });
  }

  /// Probability of the sampled lobe.
  static SHEAF_INLINE Float<L> choice(const DispersiveFresnel<L>& f, Mask<L> reflected) {
    return select(reflected, f.probability, Float<L>(1.0f) - f.probability);
  }

  /// Fraction of light that the facets reflect or refract, without shadowing.
  SHEAF_INLINE Spectrum<L> scattered(const DispersiveFresnel<L>& f, Mask<L> reflected) const {
    using F = Float<L>;
    const F through = (F(1.0f) - f.first.reflectance) / (f.first.eta * f.first.eta);
    return select<L>(reflected, this->reflectance * f.reflectance,
                     this->transmittance * first_for_all<L>(f.single, through));
  }
};

template <class L>
struct DispersiveRoughDielectricBeckmannBsdf : DispersiveRoughDielectricModel<L, BeckmannDistribution> {
  using Closure = DispersiveRoughDielectricBeckmannClosure;
};

template <class L> struct DispersiveRoughDielectricGgxBsdf : DispersiveRoughDielectricModel<L, GgxDistribution> {
  using Closure = DispersiveRoughDielectricGgxClosure;
};

template <> struct BsdfOf<DispersiveRoughDielectricBeckmannClosure> : BsdfTag<DispersiveRoughDielectricBeckmannBsdf> {};
template <> struct BsdfOf<DispersiveRoughDielectricGgxClosure> : BsdfTag<DispersiveRoughDielectricGgxBsdf> {};

}  // namespace sheaf
