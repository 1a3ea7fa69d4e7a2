// The energy-conserving Phong BRDF (Lafortune and Willems, "Using the Modified Phong Reflectance Model for Physically
// Based Rendering", 1994, equations 2 and 9):
//   f = diffuse / pi + specular (n + 2) / (2 pi) cos^n a,  a: angle between wi and the mirror direction of wo.
// The lobe is sampled with the pdf (n + 1) / (2 pi) cos^n a. Samples below the surface are lost.
#pragma once

#include "core/math/frame.h"
#include "core/sampling/warp.h"
#include "kernels/bsdf/diffuse_base.h"
#include "scene/materials/phong.h"

namespace sheaf {

template <class L> struct PhongBsdf : PhongParameters<L> {
  using Closure = PhongClosure;
  static constexpr bool kIsSpecular = false, kIsAnisotropic = false;

  SHEAF_INLINE BsdfValue<L> evaluate(Vec3<L> wo, Vec3<L> wi) const {
    using F = Float<L>;
    const auto above = (wo.z > F(0.0f)) & (wi.z > F(0.0f));
    const F cosine_pdf = select(above, cosine_hemisphere_pdf_solid_angle(wi.z), F(0.0f));
    const F cos_a = min(fma(wo.z, wi.z, -fma(wo.x, wi.x, wo.y * wi.y)), F(1.0f)), n = this->exponent;
    const F power = exp(n * log(max(cos_a, F(1e-30f))));
    const F lobe = select(above & (cos_a > F(0.0f)), F(0.5f * kInvPi) * power, F(0.0f));
    return {this->diffuse * cosine_pdf + this->specular * ((n + F(2.0f)) * lobe * wi.z),
            lerp(probability(), cosine_pdf, (n + F(1.0f)) * lobe)};
  }

  SHEAF_INLINE BsdfSample<L> sample(Vec3<L> wo, const Random4<L>& u) const {
    using F = Float<L>;
    const F cos_a = exp(log(max(u.y, F(1e-30f))) / (this->exponent + F(1.0f)));
    const F sin_a = safe_sqrt(F(1.0f) - cos_a * cos_a);
    const auto azimuth = sincos_2pi<L>(u.z);
    const Vec3<L> around{sin_a * azimuth.cos, sin_a * azimuth.sin, cos_a};
    const Vec3<L> glossy = Frame<L>::from_normal({-wo.x, -wo.y, wo.z}).to_world(around);
    return sample_specular_or_diffuse<L>(glossy, probability(), u,
                                         [&](Vec3<L> wi) SHEAF_LAMBDA_INLINE { return evaluate(wo, wi); });
  }

 private:
  SHEAF_INLINE Float<L> probability() const { return lobe_probability<L>(this->specular, this->diffuse); }
};

template <> struct BsdfOf<PhongClosure> : BsdfTag<PhongBsdf> {};

}  // namespace sheaf
