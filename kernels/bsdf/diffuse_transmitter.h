// Diffuse transmission: f = transmittance / pi for directions on opposite sides of the surface. The surface is a thin
// sheet without interior, so radiance is not scaled.
#pragma once

#include "core/warp.h"
#include "kernels/bsdf/bsdf.h"
#include "scene/materials/diffuse_transmitter.h"

namespace sheaf {

template <class L> struct DiffuseTransmitterBsdf : DiffuseTransmitterParameters<L> {
  using Closure = DiffuseTransmitterClosure;
  static constexpr bool kIsSpecular = false, kIsAnisotropic = false;

  SHEAF_INLINE BsdfValue<L> evaluate(Vec3<L> wo, Vec3<L> wi) const {
    const Float<L> pdf = cosine_hemisphere_pdf_solid_angle(-wi.z * side(wo));
    return {this->transmittance * pdf, pdf};
  }

  SHEAF_INLINE BsdfSample<L> sample(Vec3<L> wo, const Random4<L>& u) const {
    BsdfSample<L> s;
    s.wi = square_to_cosine_hemisphere<L>(u.y, u.z);
    s.pdf_solid_angle = cosine_hemisphere_pdf_solid_angle(s.wi.z);
    s.wi.z = -s.wi.z * side(wo);
    s.valid = s.pdf_solid_angle > Float<L>(0.0f);
    s.weight = this->transmittance;
    s.eta_scale = Float<L>(1.0f);
    return s;
  }

 private:
  static SHEAF_INLINE Float<L> side(Vec3<L> wo) { return copysign(Float<L>(1.0f), wo.z); }
};

template <> struct BsdfOf<DiffuseTransmitterClosure> : BsdfTag<DiffuseTransmitterBsdf> {};

}  // namespace sheaf
