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

  SHEAF_INLINE BsdfValue<L> evaluate(Vec3<L>, Vec3<L>) const { return {Spectrum<L>(Float<L>(0.0f)), Float<L>(0.0f)}; }

  SHEAF_INLINE BsdfSample<L> sample(Vec3<L> wo, const Random4<L>&) const {
    const auto& n = this->eta;
    const auto& a = this->k;
    BsdfSample<L> s;
    s.wi = {-wo.x, -wo.y, wo.z};
    s.valid = wo.z > Float<L>(0.0f);
    s.weight =
        this->reflectance * Spectrum<L>{fresnel_conductor(wo.z, n.c0, a.c0), fresnel_conductor(wo.z, n.c1, a.c1),
                                        fresnel_conductor(wo.z, n.c2, a.c2), fresnel_conductor(wo.z, n.c3, a.c3)};
    s.pdf_solid_angle = Float<L>(0.0f);
    s.eta_scale = Float<L>(1.0f);
    return s;
  }
};

}  // namespace sheaf
