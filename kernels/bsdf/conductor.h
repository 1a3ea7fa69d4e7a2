// Specular reflection by a smooth conductor, with the exact Fresnel reflectance per wavelength.
#pragma once

#include "kernels/bsdf/bsdf.h"
#include "kernels/bsdf/fresnel.h"
#include "scene/materials/conductor.h"

namespace sheaf {

template <class L> struct ConductorBsdf : ConductorParameters<L> {
  using Closure = ConductorClosure;
  static constexpr bool kIsSpecular = true, kIsAnisotropic = false;
  static constexpr unsigned kNumbers = 0;

  SHEAF_INLINE BsdfValue<L> evaluate(Vec3<L>, Vec3<L>) const { return {}; }

  SHEAF_INLINE BsdfSample<L> sample(Vec3<L> wo, const Random4<L>&) const {
    BsdfSample<L> s;
    s.wi = {-wo.x, -wo.y, wo.z};
    s.valid = wo.z > Float<L>(0.0f);
    s.weight = this->reflectance * fresnel_conductor<L>(wo.z, this->eta, this->k);
    s.pdf_solid_angle = Float<L>(0.0f);
    s.eta_scale = Float<L>(1.0f);
    return s;
  }
};

template <> struct BsdfOf<ConductorClosure> : BsdfTag<ConductorBsdf> {};

}  // namespace sheaf
