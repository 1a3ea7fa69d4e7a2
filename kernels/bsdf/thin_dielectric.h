// A thin dielectric: specular reflection, and transmission straight through. All internal reflections between its two
// interfaces are summed: the reflectance is 2 R / (1 + R) (Stokes 1862). Light is not displaced.
#pragma once

#include "kernels/bsdf/bsdf.h"
#include "kernels/bsdf/fresnel.h"
#include "scene/materials/dielectric.h"

namespace sheaf {

template <class L> struct ThinDielectricBsdf : DielectricParameters<L> {
  using Closure = ThinDielectricClosure;
  static constexpr bool kIsSpecular = true, kIsAnisotropic = false;

  SHEAF_INLINE BsdfValue<L> evaluate(Vec3<L>, Vec3<L>) const { return {}; }

  /// `cos_theta`: cosine to the normal, on either side.
  SHEAF_INLINE StraightTransmission<L> passage(Float<L> cos_theta) const {
    using F = Float<L>;
    const F once = fresnel_dielectric<L>(abs(cos_theta), this->eta).reflectance;
    const F through = (F(1.0f) - once) / (F(1.0f) + once);
    return {this->transmittance * through, through};
  }

  SHEAF_INLINE BsdfSample<L> sample(Vec3<L> wo, const Random4<L>& u) const {
    using F = Float<L>;
    const F once = fresnel_dielectric<L>(abs(wo.z), this->eta).reflectance;
    const auto reflected = u.x * (F(1.0f) + once) < once + once;
    BsdfSample<L> s;
    s.wi = {-wo.x, -wo.y, select(reflected, wo.z, -wo.z)};
    s.weight = select<L>(reflected, this->reflectance, this->transmittance);
    s.pdf_solid_angle = F(0.0f);
    s.eta_scale = F(1.0f);
    s.valid = wo.z != F(0.0f);
    return s;
  }
};

template <> struct BsdfOf<ThinDielectricClosure> : BsdfTag<ThinDielectricBsdf> {};

}  // namespace sheaf
