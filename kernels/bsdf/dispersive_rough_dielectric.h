// A rough dielectric boundary whose index of refraction depends on the wavelength: RoughDielectricModel of spectral
// mode. Refraction keeps the first wavelength only, in both evaluation and sampling, so that light sampling and BSDF
// sampling estimate the same integral; see dispersive_dielectric.h.
#pragma once

#include "kernels/bsdf/dispersive_dielectric.h"
#include "kernels/bsdf/rough_dielectric.h"

namespace sheaf {

/// Reflection and transmission by a facet of a boundary with one index of refraction per wavelength.
template <class L> struct DispersiveFacetFresnel {
  using F = Float<L>;
  using Parameters = DispersiveRoughDielectricParameters<L>;

  const Parameters& boundary;
  DispersiveFresnel<L> fresnel;

  SHEAF_INLINE DispersiveFacetFresnel(const Parameters& parameters, const Spectrum<L>& indices, F cos_o)
      : boundary(parameters),
        fresnel(fresnel_dispersive<L>(cos_o, indices, parameters.specular, parameters.specular_color)) {}

  // As in FacetFresnel.
  SHEAF_INLINE F probability() const { return fresnel.probability; }
  SHEAF_INLINE F cos_transmitted() const { return fresnel.first.cos_transmitted; }
  SHEAF_INLINE F chosen(Mask<L> reflected) const {
    return select(reflected, fresnel.probability, F(1.0f) - fresnel.probability);
  }
  SHEAF_INLINE Spectrum<L> f_cos(Mask<L> reflected, F pdf, F shadowing) const {
    const F through = (F(1.0f) - fresnel.first.reflectance) / (fresnel.first.eta * fresnel.first.eta);
    return select<L>(reflected, boundary.reflectance * fresnel.reflectance,
                     boundary.transmittance * first_for_all<L>(fresnel.single, through)) *
           (pdf * shadowing);
  }
  SHEAF_INLINE Spectrum<L> weight(Mask<L> reflected, F shadowing) const {
    return f_cos(reflected, F(1.0f), shadowing / chosen(reflected));
  }
};

template <class L>
struct DispersiveRoughDielectricBeckmannBsdf : RoughDielectricModel<L, BeckmannDistribution, DispersiveFacetFresnel> {
  using Closure = DispersiveRoughDielectricBeckmannClosure;
  static constexpr bool kDisperses = true;
};

template <class L>
struct DispersiveRoughDielectricGgxBsdf : RoughDielectricModel<L, GgxDistribution, DispersiveFacetFresnel> {
  using Closure = DispersiveRoughDielectricGgxClosure;
  static constexpr bool kDisperses = true;
};

template <> struct BsdfOf<DispersiveRoughDielectricBeckmannClosure> : BsdfTag<DispersiveRoughDielectricBeckmannBsdf> {};
template <> struct BsdfOf<DispersiveRoughDielectricGgxClosure> : BsdfTag<DispersiveRoughDielectricGgxBsdf> {};

}  // namespace sheaf
