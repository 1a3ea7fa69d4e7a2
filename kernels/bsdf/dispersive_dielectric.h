// Smooth and thin dielectrics whose index of refraction depends on the wavelength: DielectricBsdf and
// ThinDielectricBsdf of spectral mode.
//
// A refracted direction is valid for the first wavelength only. The path drops the other three, and the first counts
// for all four: alone it has the same pdf as each of the four (Wilkie et al., "Hero Wavelength Spectral Sampling", EGSR
// 2014; Pharr et al. 2023, section 4.5.4). Reflection and transmission through a thin dielectric have the same
// direction at all wavelengths. There the path keeps all of them, each with its own Fresnel reflectance, and the mean
// of the four chooses the lobe.
#pragma once

#include "kernels/bsdf/bsdf.h"
#include "kernels/bsdf/specular_scale.h"
#include "scene/materials/dielectric.h"

namespace sheaf {

/// Fresnel reflectances for four indices of refraction.
template <class L> struct DispersiveFresnel {
  DielectricFresnel<L> first;  ///< at the first wavelength
  Spectrum<L> reflectance;
  typename L::Float probability;  ///< of choosing reflection: mean of the reflectances
  /// all four indices are equal, as on a path with one wavelength left
  typename L::Mask single;
};

/// As fresnel_dielectric(), with one index per wavelength.
template <class L> SHEAF_INLINE DispersiveFresnel<L> fresnel_dispersive(Float<L> cos_incident, const Spectrum<L>& eta) {
  const auto at = [&](Float<L> index)
                      SHEAF_LAMBDA_INLINE { return fresnel_dielectric<L>(cos_incident, index).reflectance; };
  DispersiveFresnel<L> f;
  f.first = fresnel_dielectric<L>(cos_incident, eta.c0);
  f.reflectance = {f.first.reflectance, at(eta.c1), at(eta.c2), at(eta.c3)};
  f.probability = total(f.reflectance) * Float<L>(0.25f);
  f.single = is_same_in_all<L>(eta);
  return f;
}

/// The same, scaled by the factors of kernels/bsdf/specular_scale.h.
template <class L>
SHEAF_INLINE DispersiveFresnel<L> fresnel_dispersive(Float<L> cos_incident, const Spectrum<L>& eta, Float<L> specular,
                                                     const Spectrum<L>& color) {
  DispersiveFresnel<L> f = fresnel_dispersive<L>(cos_incident, eta);
  const Spectrum<L> r = f.reflectance;
  f.reflectance = {
      scaled_reflectance(r.c0, eta.c0, specular, color.c0), scaled_reflectance(r.c1, eta.c1, specular, color.c1),
      scaled_reflectance(r.c2, eta.c2, specular, color.c2), scaled_reflectance(r.c3, eta.c3, specular, color.c3)};
  f.first.reflectance = f.reflectance.c0;
  f.probability = total(f.reflectance) * Float<L>(0.25f);
  return f;
}

/// Weight of refraction, given the weight `through` of the first wavelength. The first component counts for all four
/// wavelengths and is 4 `through`; the others are 0. Lanes with `single` have `through` in all components.
template <class L> SHEAF_INLINE Spectrum<L> first_for_all(Mask<L> single, Float<L> through) {
  using F = Float<L>;
  const F others = select(single, through, F(0.0f));
  return {select(single, through, through * F(4.0f)), others, others, others};
}

template <class L> struct DispersiveDielectricBsdf : DispersiveDielectricParameters<L> {
  using Closure = DispersiveDielectricClosure;
  static constexpr bool kIsSpecular = true, kIsAnisotropic = false, kDisperses = true;

  SHEAF_INLINE BsdfValue<L> evaluate(Vec3<L>, Vec3<L>) const { return {}; }

  SHEAF_INLINE BsdfSample<L> sample(Vec3<L> wo, const Random4<L>& u) const {
    using F = Float<L>;
    const auto f = fresnel_dispersive<L>(wo.z, this->eta, this->specular, this->specular_color);
    const auto reflected = u.x < f.probability;
    const F inverse_eta = F(1.0f) / f.first.eta;
    const F per_choice = F(1.0f) / select(reflected, f.probability, F(1.0f) - f.probability);
    const Spectrum<L> refracted =
        first_for_all<L>(f.single, (F(1.0f) - f.first.reflectance) * per_choice * (inverse_eta * inverse_eta));
    BsdfSample<L> s;
    s.wi =
        select<L>(reflected, {-wo.x, -wo.y, wo.z}, {-wo.x * inverse_eta, -wo.y * inverse_eta, f.first.cos_transmitted});
    s.weight = select<L>(reflected, this->reflectance * (f.reflectance * per_choice), this->transmittance * refracted);
    s.eta_scale = select(reflected, F(1.0f), f.first.eta * f.first.eta);
    s.pdf_solid_angle = F(0.0f);
    s.valid = s.wi.z != F(0.0f);
    return s;
  }
};

template <class L> struct DispersiveThinDielectricBsdf : DispersiveDielectricParameters<L> {
  using Closure = DispersiveThinDielectricClosure;
  static constexpr bool kIsSpecular = true, kIsAnisotropic = false;

  SHEAF_INLINE BsdfValue<L> evaluate(Vec3<L>, Vec3<L>) const { return {}; }

  /// See ThinDielectricBsdf::passage().
  SHEAF_INLINE StraightTransmission<L> passage(Float<L> cos_theta) const {
    using F = Float<L>;
    const Spectrum<L> once = interface(cos_theta);
    const Spectrum<L> through =
        map_spectrum<L>(once, [](F r) SHEAF_LAMBDA_INLINE { return (F(1.0f) - r) / (F(1.0f) + r); });
    return {this->transmittance * through, total(through) * F(0.25f)};
  }

  SHEAF_INLINE BsdfSample<L> sample(Vec3<L> wo, const Random4<L>& u) const {
    using F = Float<L>;
    const Spectrum<L> once = interface(wo.z);
    const Spectrum<L> back = map_spectrum<L>(once, [](F r) SHEAF_LAMBDA_INLINE { return (r + r) / (F(1.0f) + r); });
    const F probability = total(back) * F(0.25f);
    const auto reflected = u.x < probability;
    const F per_choice = F(1.0f) / select(reflected, probability, F(1.0f) - probability);
    const Spectrum<L> through = map_spectrum<L>(back, [](F r) SHEAF_LAMBDA_INLINE { return F(1.0f) - r; });
    BsdfSample<L> s;
    s.wi = {-wo.x, -wo.y, select(reflected, wo.z, -wo.z)};
    s.weight = select<L>(reflected, this->reflectance * back, this->transmittance * through) * per_choice;
    s.pdf_solid_angle = F(0.0f);
    s.eta_scale = F(1.0f);
    s.valid = wo.z != F(0.0f);
    return s;
  }

 private:
  /// Reflectances of one of the two interfaces.
  SHEAF_INLINE Spectrum<L> interface(Float<L> cos_theta) const {
    return fresnel_dispersive<L>(abs(cos_theta), this->eta, this->specular, this->specular_color).reflectance;
  }
};

template <> struct BsdfOf<DispersiveDielectricClosure> : BsdfTag<DispersiveDielectricBsdf> {};
template <> struct BsdfOf<DispersiveThinDielectricClosure> : BsdfTag<DispersiveThinDielectricBsdf> {};

}  // namespace sheaf
