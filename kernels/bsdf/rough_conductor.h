// Reflection by a rough conductor: a microfacet BRDF with the exact Fresnel reflectance per wavelength (Cook and
// Torrance 1982; Walter et al. 2007, equation 20). Multiple scattering between facets is lost.
#pragma once

#include "kernels/bsdf/bsdf.h"
#include "kernels/bsdf/fresnel.h"
#include "kernels/bsdf/microfacet.h"
#include "scene/materials/conductor.h"

namespace sheaf {

/// `Distribution`: GgxDistribution or BeckmannDistribution.
template <class L, template <class> class Distribution> struct RoughConductorModel : RoughConductorParameters<L> {
  static constexpr bool kIsSpecular = false, kIsAnisotropic = true;
  static constexpr unsigned kNumbers = kNumberY | kNumberZ;

  SHEAF_INLINE BsdfValue<L> evaluate(Vec3<L> wo, Vec3<L> wi) const {
    const auto r = evaluate_reflection(facets(), wo, wi);
    return {fresnel(r.cos_facet) * (r.pdf_solid_angle * r.shadowing), r.pdf_solid_angle};
  }

  SHEAF_INLINE BsdfSample<L> sample(Vec3<L> wo, const Random4<L>& u) const {
    const auto r = sample_reflection(facets(), wo, u.y, u.z);
    return {r.wi, fresnel(r.cos_facet) * r.shadowing, r.pdf_solid_angle, Float<L>(1.0f),
            r.pdf_solid_angle > Float<L>(0.0f)};
  }

 private:
  SHEAF_INLINE Distribution<L> facets() const { return {this->alpha_u, this->alpha_v}; }

  SHEAF_INLINE Spectrum<L> fresnel(Float<L> cos_facet) const {
    return this->reflectance * fresnel_conductor<L>(min(cos_facet, Float<L>(1.0f)), this->eta, this->k);
  }
};

template <class L> struct RoughConductorBeckmannBsdf : RoughConductorModel<L, BeckmannDistribution> {
  using Closure = RoughConductorBeckmannClosure;
};

template <class L> struct RoughConductorGgxBsdf : RoughConductorModel<L, GgxDistribution> {
  using Closure = RoughConductorGgxClosure;
};

template <> struct BsdfOf<RoughConductorBeckmannClosure> : BsdfTag<RoughConductorBeckmannBsdf> {};
template <> struct BsdfOf<RoughConductorGgxClosure> : BsdfTag<RoughConductorGgxBsdf> {};

}  // namespace sheaf
