// Specular reflection and refraction at a smooth dielectric boundary. The Fresnel reflectance, which
// may be scaled (kernels/bsdf/specular_scale.h), is the probability of reflection. Radiance that enters a medium is
// scaled by the squared relative index (Veach 1997, section 5.2).
#pragma once

#include "kernels/bsdf/bsdf.h"
#include "kernels/bsdf/specular_scale.h"
#include "scene/materials/dielectric.h"

namespace sheaf {

template <class L> struct DielectricBsdf : DielectricParameters<L> {
  using Closure = DielectricClosure;
  static constexpr bool kIsSpecular = true, kIsAnisotropic = false;
  static constexpr unsigned kNumbers = kNumberX;

  SHEAF_INLINE BsdfValue<L> evaluate(Vec3<L>, Vec3<L>) const { return {}; }

  SHEAF_INLINE BsdfSample<L> sample(Vec3<L> wo, const Random4<L>& u) const {
    using F = Float<L>;
    const auto fresnel = fresnel_dielectric<L>(wo.z, this->eta);
    const SpecularChoice<L> choice(fresnel.reflectance, this->eta, this->specular, this->specular_color);
    const auto reflected = u.x < choice.probability;
    const F inverse_eta = F(1.0f) / fresnel.eta;
    BsdfSample<L> s;
    s.wi =
        select<L>(reflected, {-wo.x, -wo.y, wo.z}, {-wo.x * inverse_eta, -wo.y * inverse_eta, fresnel.cos_transmitted});
    s.weight = select<L>(reflected, this->reflectance, this->transmittance * (inverse_eta * inverse_eta)) *
               choice.weight(reflected);
    s.eta_scale = select(reflected, F(1.0f), fresnel.eta * fresnel.eta);
    s.pdf_solid_angle = F(0.0f);
    s.valid = s.wi.z != F(0.0f);
    return s;
  }
};

template <> struct BsdfOf<DielectricClosure> : BsdfTag<DielectricBsdf> {};

}  // namespace sheaf
