// Lambertian reflection: f = reflectance / pi on the side of the normal.
#pragma once

#include "core/sampling/warp.h"
#include "kernels/bsdf/bsdf.h"
#include "scene/materials/diffuse.h"

namespace sheaf {

template <class L> struct DiffuseBsdf : DiffuseParameters<L> {
  using Closure = DiffuseClosure;
  static constexpr bool kIsSpecular = false, kIsAnisotropic = false;
  static constexpr unsigned kNumbers = kNumberY | kNumberZ;

  SHEAF_INLINE BsdfValue<L> evaluate(Vec3<L> wo, Vec3<L> wi) const {
    const Float<L> pdf = select(wo.z > Float<L>(0.0f), cosine_hemisphere_pdf_solid_angle(wi.z), Float<L>(0.0f));
    return {this->reflectance * pdf, pdf};
  }

  SHEAF_INLINE BsdfSample<L> sample(Vec3<L> wo, const Random4<L>& u) const {
    BsdfSample<L> s;
    s.wi = square_to_cosine_hemisphere<L>(u.y, u.z);
    s.pdf_solid_angle = cosine_hemisphere_pdf_solid_angle(s.wi.z);
    s.valid = (wo.z > Float<L>(0.0f)) & (s.pdf_solid_angle > Float<L>(0.0f));
    s.weight = this->reflectance;
    s.eta_scale = Float<L>(1.0f);
    return s;
  }
};

template <> struct BsdfOf<DiffuseClosure> : BsdfTag<DiffuseBsdf> {};

}  // namespace sheaf
