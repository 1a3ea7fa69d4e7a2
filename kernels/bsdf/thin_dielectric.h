// A thin dielectric: specular reflection, and transmission straight through. All internal reflections between its two
// interfaces are summed: the reflectance is 2 R / (1 + R) (Stokes 1862). Light is not displaced.
#pragma once

#include "kernels/bsdf/bsdf.h"
#include "kernels/bsdf/specular_scale.h"
#include "scene/materials/dielectric.h"

namespace sheaf {

template <class L> struct ThinDielectricBsdf : DielectricParameters<L> {
  using Closure = ThinDielectricClosure;
  static constexpr bool kIsSpecular = true, kIsAnisotropic = false;

  SHEAF_INLINE BsdfValue<L> evaluate(Vec3<L>, Vec3<L>) const { return {}; }

  /// `cos_theta`: cosine to the normal, on either side.
  SHEAF_INLINE StraightTransmission<L> passage(Float<L> cos_theta) const {
    using F = Float<L>;
    const SpecularChoice<L> once = interface(cos_theta);
    const auto through = [](F r) SHEAF_LAMBDA_INLINE { return (F(1.0f) - r) / (F(1.0f) + r); };
    return {this->transmittance * map_spectrum<L>(once.reflectance, through), through(once.probability)};
  }

  SHEAF_INLINE BsdfSample<L> sample(Vec3<L> wo, const Random4<L>& u) const {
    using F = Float<L>;
    const SpecularChoice<L> once = interface(wo.z);
    const F chosen = once.probability;
    const auto reflected = u.x * (F(1.0f) + chosen) < chosen + chosen;
    // Reflectance or transmittance of the pane, over its probability
    const auto fraction = [&](F r)
                              SHEAF_LAMBDA_INLINE { return select(reflected, r + r, F(1.0f) - r) / (F(1.0f) + r); };
    const F probability = max(fraction(chosen), F(1e-20f));
    const auto weight = [&](F r) SHEAF_LAMBDA_INLINE { return fraction(r) / probability; };
    BsdfSample<L> s;
    s.wi = {-wo.x, -wo.y, select(reflected, wo.z, -wo.z)};
    s.weight = select<L>(reflected, this->reflectance, this->transmittance) * map_spectrum<L>(once.reflectance, weight);
    s.pdf_solid_angle = F(0.0f);
    s.eta_scale = F(1.0f);
    s.valid = wo.z != F(0.0f);
    return s;
  }

 private:
  /// Reflection at one of the two interfaces.
  SHEAF_INLINE SpecularChoice<L> interface(Float<L> cos_theta) const {
    return {fresnel_dielectric<L>(abs(cos_theta), this->eta).reflectance, this->eta, this->specular,
            this->specular_color};
  }
};

template <> struct BsdfOf<ThinDielectricClosure> : BsdfTag<ThinDielectricBsdf> {};

}  // namespace sheaf
