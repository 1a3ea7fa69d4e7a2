// Diffuse transmission and reflection: f = transmittance / pi for directions on opposite sides of the surface, and
// reflectance / pi for directions on the same side. The surface is a thin sheet without interior, so radiance is not
// scaled.
#pragma once

#include "core/sampling/warp.h"
#include "kernels/bsdf/bsdf.h"
#include "scene/materials/diffuse_transmitter.h"

namespace sheaf {

template <class L> struct DiffuseTransmitterBsdf : DiffuseTransmitterParameters<L> {
  using Closure = DiffuseTransmitterClosure;
  static constexpr bool kIsSpecular = false, kIsAnisotropic = false;

  SHEAF_INLINE BsdfValue<L> evaluate(Vec3<L> wo, Vec3<L> wi) const {
    using F = Float<L>;
    const F height = wi.z * side(wo), cosine_pdf = cosine_hemisphere_pdf_solid_angle(abs(height));
    const auto reflected = height > F(0.0f);
    return {select<L>(reflected, this->reflectance, this->transmittance) * cosine_pdf,
            cosine_pdf * probability(reflected)};
  }

  SHEAF_INLINE BsdfSample<L> sample(Vec3<L> wo, const Random4<L>& u) const {
    using F = Float<L>;
    const auto reflected = u.x < probability(Mask<L>(true));
    const F chosen = probability(reflected);
    BsdfSample<L> s;
    s.wi = square_to_cosine_hemisphere<L>(u.y, u.z);
    s.pdf_solid_angle = cosine_hemisphere_pdf_solid_angle(s.wi.z) * chosen;
    s.wi.z = select(reflected, s.wi.z, -s.wi.z) * side(wo);
    s.valid = s.pdf_solid_angle > F(0.0f);
    s.weight = select<L>(reflected, this->reflectance, this->transmittance) * (F(1.0f) / max(chosen, F(1e-20f)));
    s.eta_scale = F(1.0f);
    return s;
  }

 private:
  /// Probability of sampling reflection, or transmission.
  SHEAF_INLINE Float<L> probability(Mask<L> reflected) const {
    using F = Float<L>;
    const F back = max_component(this->reflectance), through = max_component(this->transmittance);
    const F reflected_fraction = back / max(back + through, F(1e-20f));
    return select(reflected, reflected_fraction, F(1.0f) - reflected_fraction);
  }

  static SHEAF_INLINE Float<L> side(Vec3<L> wo) { return copysign(Float<L>(1.0f), wo.z); }
};

template <> struct BsdfOf<DiffuseTransmitterClosure> : BsdfTag<DiffuseTransmitterBsdf> {};

}  // namespace sheaf
