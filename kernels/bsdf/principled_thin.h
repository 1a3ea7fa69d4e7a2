// The principled BSDF for thin surfaces (Burley 2015, section 5) as implemented by Mitsuba 3: leaves, paper, window
// panes. Both sides are alike, and transmission does not bend light.
//
//   f = (1 - spec_trans) ((1 - d) (diffuse + sheen) + d base_color / pi)
//       + spec_trans (specular reflection + base_color refraction)
// where d = diff_trans / 2. The term with d transmits; diffuse and sheen reflect. Refraction is the reflection lobe
// mirrored to the other side. Its roughness is scaled by the index of refraction, because light passes two interfaces.
// Sheen and spec_tint may raise the albedo above 1.
#pragma once

#include "kernels/bsdf/fresnel.h"
#include "kernels/bsdf/principled_lobes.h"
#include "scene/materials/principled_thin.h"

namespace sheaf {

template <class L> struct PrincipledThinBsdf : PrincipledThinParameters<L> {
  using Closure = PrincipledThinClosure;
  static constexpr bool kIsSpecular = false, kIsAnisotropic = true;
  using F = typename L::Float;

  BsdfValue<L> evaluate(Vec3<L> wo, Vec3<L> wi) const;

  BsdfSample<L> sample(Vec3<L> wo, const Random4<L>& u) const;

 private:
  /// Probabilities of sampling the lobes.
  struct Probabilities {
    F specular_reflect, specular_transmit, diffuse_reflect, diffuse_transmit;
  };

  static SHEAF_INLINE F side_of(Vec3<L> wo) { return select(wo.z < F(0.0f), F(-1.0f), F(1.0f)); }

  /// Microfacet distribution of reflection or of transmission (Burley 2015, figure 15).
  SHEAF_INLINE GgxDistribution<L> facets(Mask<L> reflects) const {
    const F scale = fma(F(0.65f), this->eta, F(-0.35f));
    return burley_ggx<L>(this->roughness * select(reflects, F(1.0f), scale), this->anisotropic);
  }

  /// Roughly in proportion to what each lobe scatters, for an outgoing direction at cosine `cos_o` to the normal.
  SHEAF_INLINE Probabilities probabilities(F cos_o) const {
    const F one(1.0f);
    const F fresnel = lerp(schlick_weight(cos_o), normal_reflectance(this->eta), one);
    // Facets are tilted against the surface, so the true reflectance may differ: neither lobe gets a probability near
    // 0.
    const F reflectance = fma(F(0.8f), fresnel, F(0.1f)), base = max_component(this->base_color);
    const F d = F(0.5f) * this->diff_trans, diffuse = one - this->spec_trans;
    const F sheen_term = F(0.1f) * this->sheen * (schlick_weight(cos_o) + F(0.02f));
    const Probabilities p{this->spec_trans * reflectance, this->spec_trans * (one - reflectance) * base,
                          diffuse * (one - d) * (base + sheen_term), diffuse * d * base};
    const F scale =
        one / max(p.specular_reflect + p.specular_transmit + p.diffuse_reflect + p.diffuse_transmit, F(1e-20f));
    return {p.specular_reflect * scale, p.specular_transmit * scale, p.diffuse_reflect * scale,
            p.diffuse_transmit * scale};
  }

  /// f |cos(wi)| and pdf, for wo above the surface.
  SHEAF_INLINE BsdfValue<L> evaluate_above(Vec3<L> wo, Vec3<L> wi, const Probabilities& p) const {
    const F one(1.0f), zero(0.0f);
    const Mask<L> reflects = wi.z > zero, lit = (wo.z > zero) & (reflects | (wi.z < zero));
    const F cos_i = abs(wi.z), d = F(0.5f) * this->diff_trans;
    const Vec3<L> sum = wo + Vec3<L>{wi.x, wi.y, cos_i};
    const Vec3<L> h = sum * (one / sqrt(max(length_squared(sum), F(1e-20f))));
    const F cos_d = max(dot(wo, h), zero);
    const F lambert = select(lit, cos_i * F(kInvPi), zero);

    BsdfValue<L> value;
    // Evaluate diffuse reflection and transmission
    const F diffuse = (one - this->spec_trans) * lambert;
    const F shape = select(reflects, (one - d) * near_diffuse(wo.z, cos_i, dot(wi, h)), d);
    value.f_cos = this->base_color * (diffuse * shape);
    value.pdf_solid_angle = lambert * select(reflects, p.diffuse_reflect, p.diffuse_transmit);
    // Add sheen
    if (any(this->sheen > zero)) {
      const auto& c = this->base_color;
      const Spectrum<L> tint =
          lerp(this->sheen_tint, Spectrum<L>(one), hue(c, rec709_luminance(c, this->base_luminance)));
      const F amount = this->sheen * diffuse * F(kPi) * (one - d) * schlick_weight(cos_d);
      value.f_cos = value.f_cos + tint * select(reflects, amount, zero);
    }
    // Add the specular lobes
    if (any(this->spec_trans > zero)) add_specular(value, wo, wi, h, cos_d, lit, p);
    return value;
  }

  SHEAF_INLINE F near_diffuse(F cos_o, F cos_i, F cos_d) const {
    const DiffuseAngles<L> angles{cos_o, schlick_weight(cos_o), cos_i, schlick_weight(cos_i),
                                  this->roughness * sqr(cos_d)};
    return any(this->flatness > F(0.0f)) ? angles.diffuse(this->flatness) : angles.diffuse();
  }

  SHEAF_INLINE void add_specular(BsdfValue<L>& value, Vec3<L> wo, Vec3<L> wi, Vec3<L> h, F cos_d, Mask<L> lit,
                                 const Probabilities& p) const {
    const F one(1.0f), zero(0.0f);
    const Mask<L> reflects = wi.z > zero;
    const auto fresnel = fresnel_dielectric<L>(cos_d, this->eta);
    const auto& c = this->base_color;
    Spectrum<L> reflected(fresnel.reflectance);
    if (any(this->spec_tint > zero)) {
      const F weight = schlick_weight(select(this->eta > one, cos_d, -fresnel.cos_transmitted));
      const Spectrum<L> f0 = hue(c, rec709_luminance(c, this->base_luminance)) * normal_reflectance(this->eta);
      reflected = lerp(this->spec_tint, reflected, lerp(weight, f0, Spectrum<L>(one)));
    }
    // Refracted light must also leave on the far side of the facet.
    const Mask<L> possible = lit & select(reflects, dot(wi, h) > zero, dot(wi, h) < zero);
    const GgxDistribution<L> distribution = facets(reflects);
    using Terms = GgxTerms<L>;
    const Terms terms(distribution, h, Terms::span(distribution, wo), Terms::span(distribution, wi));
    const F bend = select(possible, F(0.25f), zero), scattered = this->spec_trans * terms.masked * bend * abs(wi.z);
    value.f_cos = value.f_cos + select<L>(reflects, reflected, c * (one - fresnel.reflectance)) * scattered;
    value.pdf_solid_angle += terms.density * bend * select(reflects, p.specular_reflect, p.specular_transmit);
  }
};

template <> struct BsdfOf<PrincipledThinClosure> : BsdfTag<PrincipledThinBsdf> {};

}  // namespace sheaf
