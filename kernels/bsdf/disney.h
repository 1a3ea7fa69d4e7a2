// The Disney BRDF (Burley, "Physically Based Shading at Disney", SIGGRAPH 2012 course notes, section 5, and the
// reference implementation published with it): a diffuse base with retro-reflection and approximate subsurface
// scattering, sheen, an anisotropic GGX lobe for metals and dielectrics, and a clearcoat. It reflects only, on the side
// of the normal.
//
//   f = (1 - metallic) (base_color / pi mix(diffuse, subsurface) + sheen) + F D G / (4 cos cos) + clearcoat / 4 coat
// Masking and shadowing use Smith's term of the distribution itself, as in later editions of the notes; the first
// edition used a rougher distribution. The layers do not shadow one another: the albedo of a white diffuse base with
// its specular lobe reaches 1.7 at grazing incidence. Sheen adds up to 0.1 and the clearcoat 0.06. Metals without a
// clearcoat stay below 1.
#pragma once

#include "kernels/bsdf/principled_lobes.h"
#include "scene/materials/disney.h"

namespace sheaf {

template <class L> struct DisneyBsdf : DisneyParameters<L> {
  using Closure = DisneyClosure;
  static constexpr bool kIsSpecular = false, kIsAnisotropic = true;
  using F = typename L::Float;

  BsdfValue<L> evaluate(Vec3<L> wo, Vec3<L> wi) const;

  BsdfSample<L> sample(Vec3<L> wo, const Random4<L>& u) const;

 private:
  /// Everything that depends only on the parameters and the outgoing direction.
  struct View {
    Vec3<L> wo;
    F weight_o;  ///< Schlick weight of wo
    GgxDistribution<L> facets;
    F span_o;                         ///< GgxTerms::span() of wo
    Spectrum<L> hue;                  ///< base color scaled to luminance 1
    Spectrum<L> specular;             ///< reflectance at normal incidence
    Clearcoat<L> coat;                ///< only where p_coat > 0
    F p_diffuse, p_coat, p_specular;  ///< probabilities of sampling the lobes

    SHEAF_INLINE View(const DisneyParameters<L>& p, Vec3<L> direction)
        : wo(direction),
          weight_o(schlick_weight(wo.z)),
          facets(burley_ggx<L>(p.roughness, p.anisotropic)),
          span_o(GgxTerms<L>::span(facets, wo)) {
      const F one(1.0f);
      const auto& c = p.base_color;
      hue = sheaf::hue(c, burley_luminance(c, p.base_luminance));
      const Spectrum<L> plain = lerp(p.specular_tint, Spectrum<L>(one), hue) * (F(0.08f) * p.specular);
      specular = lerp(p.metallic, plain, c);

      const F sheen = F(0.1f) * p.sheen * (weight_o + F(0.02f));
      const F diffuse = (one - p.metallic) * (max_component(c) + sheen);
      const F coated = F(0.25f) * p.clearcoat * Clearcoat<L>::fresnel(weight_o);
      const F glossy = lerp(weight_o, max_component(specular), one);
      const F scale = one / max(diffuse + coated + glossy, F(1e-20f));
      p_diffuse = diffuse * scale;
      p_coat = coated * scale;
      p_specular = glossy * scale;
      if (any(p_coat > F(0.0f))) coat = Clearcoat<L>(p.clearcoat_gloss);
    }
  };

  SHEAF_INLINE BsdfValue<L> evaluate(const View& view, Vec3<L> wi) const {
    const F one(1.0f), zero(0.0f);
    const Mask<L> lit = (view.wo.z > zero) & (wi.z > zero);
    const Vec3<L> sum = view.wo + wi;
    const F inverse_length = one / sqrt(max(length_squared(sum), F(1e-20f)));
    const Vec3<L> h = sum * inverse_length;
    const F cos_d = max(dot(view.wo, h), zero), weight_d = schlick_weight(cos_d);
    const F cos_i = select(lit, wi.z, zero), lambert = cos_i * F(kInvPi);

    // Evaluate the diffuse base and sheen.
    const DiffuseAngles<L> angles{view.wo.z, view.weight_o, cos_i, schlick_weight(cos_i), this->roughness * sqr(cos_d)};
    const F shape = any(this->subsurface > zero) ? angles.diffuse(this->subsurface) : angles.diffuse();
    const Spectrum<L> sheen_lobe =
        lerp(this->sheen_tint, Spectrum<L>(one), view.hue) * (this->sheen * weight_d * cos_i);
    // Add the specular lobe.
    const GgxTerms<L> facets(view.facets, h, view.span_o, GgxTerms<L>::span(view.facets, wi));
    BsdfValue<L> value;
    value.f_cos = (this->base_color * (lambert * shape) + sheen_lobe) * (one - this->metallic) +
                  lerp(weight_d, view.specular, Spectrum<L>(one)) * (F(0.25f) * facets.masked * cos_i);
    value.pdf_solid_angle =
        fma(view.p_diffuse, lambert, view.p_specular * select(lit, F(0.25f) * facets.density, zero));
    // Add the clearcoat.
    if (any(view.p_coat > zero)) {
      const auto coat = view.coat.terms(view.wo, wi, h);
      // One factor 1/4 is the strength of the coat, the other belongs to 1 / (4 cos cos).
      const F strength = F(0.0625f) * this->clearcoat * view.coat.fresnel(weight_d) * cos_i;
      value.f_cos = value.f_cos + Spectrum<L>(strength * coat.masked);
      // Jacobian of reflection 1 / (4 cos_d): the length of wo + wi is 2 cos_d.
      value.pdf_solid_angle += select(lit, view.p_coat * coat.density * F(0.5f) * h.z * inverse_length, zero);
    }
    return value;
  }
};

template <> struct BsdfOf<DisneyClosure> : BsdfTag<DisneyBsdf> {};

}  // namespace sheaf
