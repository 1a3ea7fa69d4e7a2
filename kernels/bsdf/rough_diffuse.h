// The rough diffuse BRDF of Oren and Nayar ("Generalization of Lambert's Reflectance Model", SIGGRAPH 1994): Lambertian
// facets with masking, shadowing and interreflection, equations 26 to 30, or with `fast` the short form, equation 31.
//
// Their sigma is the standard deviation of the facets' slope angle in radians. It is set to alpha / sqrt(2), the
// standard deviation of a Beckmann surface's slopes along each axis. Negative values of the fit are clamped to 0. Rough
// white surfaces reflect more light than arrives at grazing angles.
#pragma once

#include "core/sampling/warp.h"
#include "kernels/bsdf/bsdf.h"
#include "scene/materials/rough_diffuse.h"

namespace sheaf {

template <class L> struct RoughDiffuseBsdf : RoughDiffuseParameters<L> {
  using Closure = RoughDiffuseClosure;
  static constexpr bool kIsSpecular = false, kIsAnisotropic = false;
  static constexpr unsigned kNumbers = kNumberY | kNumberZ;

  SHEAF_INLINE BsdfValue<L> evaluate(Vec3<L> wo, Vec3<L> wi) const {
    using F = Float<L>;
    const F pdf = select(wo.z > F(0.0f), cosine_hemisphere_pdf_solid_angle(wi.z), F(0.0f));
    const Shape shape = shape_of(wo, wi);
    return {this->reflectance * (Spectrum<L>(shape.single) + this->reflectance * shape.twice) * pdf, pdf};
  }

  SHEAF_INLINE BsdfSample<L> sample(Vec3<L> wo, const Random4<L>& u) const {
    using F = Float<L>;
    BsdfSample<L> s;
    s.wi = square_to_cosine_hemisphere<L>(u.y, u.z);
    s.pdf_solid_angle = cosine_hemisphere_pdf_solid_angle(s.wi.z);
    s.valid = (wo.z > F(0.0f)) & (s.pdf_solid_angle > F(0.0f));
    const Shape shape = shape_of(wo, s.wi);
    s.weight = this->reflectance * (Spectrum<L>(shape.single) + this->reflectance * shape.twice);
    s.eta_scale = F(1.0f);
    return s;
  }

 private:
  /// Single scattering and interreflection, as factors on a Lambertian BRDF.
  struct Shape {
    typename L::Float single, twice;
  };

  SHEAF_INLINE Shape shape_of(Vec3<L> wo, Vec3<L> wi) const {
    using F = Float<L>;
    const F one(1.0f), zero(0.0f);
    const F variance = F(0.5f) * sqr(this->alpha);
    const F cos_o = clamp(wo.z, zero, one), cos_i = clamp(wi.z, zero, one);
    const F cos_beta = max(max(cos_o, cos_i), F(1e-6f)), cos_alpha = min(cos_o, cos_i);
    const F sin_beta = safe_sqrt(one - sqr(cos_beta)), sin_alpha = safe_sqrt(one - sqr(cos_alpha));
    const F sines = sin_alpha * sin_beta;
    const F cos_phi =
        select(sines > F(1e-7f), clamp(fma(wo.x, wi.x, wo.y * wi.y) / max(sines, F(1e-7f)), -one, one), zero);
    const F tan_beta = sin_beta / cos_beta;
    const F c1 = one - F(0.5f) * variance / (variance + F(0.33f)), ratio = variance / (variance + F(0.09f));
    const F brief = c1 + F(0.45f) * ratio * max(cos_phi, zero) * sin_alpha * tan_beta;
    const Mask<L> is_fast = this->fast != Uint<L>(0u);
    if (all(is_fast)) return {brief, zero};

    // alpha and beta of the paper, over pi / 2.
    const F outer = acos(cos_alpha) * F(2.0f * kInvPi), inner = acos(min(cos_beta, one)) * F(2.0f * kInvPi);
    const F c2 = F(0.45f) * ratio * (sin_alpha - select(cos_phi < zero, inner * inner * inner, zero));
    const F c3 = F(0.125f) * ratio * sqr(outer * inner);
    const F tan_half = (sin_alpha + sin_beta) / max(cos_alpha + cos_beta, F(1e-6f));
    const F single = c1 + cos_phi * c2 * tan_beta + (one - abs(cos_phi)) * c3 * tan_half;
    const F twice = F(0.17f) * variance / (variance + F(0.13f)) * (one - cos_phi * sqr(inner));
    return {select(is_fast, brief, max(single, zero)), select(is_fast, zero, max(twice, zero))};
  }
};

template <> struct BsdfOf<RoughDiffuseClosure> : BsdfTag<RoughDiffuseBsdf> {};

}  // namespace sheaf
