// The principled BSDF of Burley 2015 as implemented by Mitsuba 3: a diffuse base with retro-reflection and sheen, a
// metal, a rough dielectric that refracts, and a clearcoat.
//
//   f = (1 - metallic)(1 - spec_trans) diffuse + (1 - metallic) sheen + specular reflection
//       + (1 - metallic) spec_trans refraction + clearcoat / 4 coat
// Sheen needs a diffuse base: it vanishes if metallic or spec_trans is 1. Seen from inside (wo.z < 0), the surface only
// reflects and refracts, and is black if spec_trans is 0. The layers do not shadow one another, so the BSDF does not
// conserve energy in general. The albedo of a white diffuse base with its specular lobe reaches 1.7 at grazing
// incidence; sheen adds up to 0.1 to any base and the clearcoat 0.03. Metals and refracting surfaces without sheen,
// clearcoat and spec_tint stay below 1. If eta is 1, there is no specular reflection, not even by metals, as in
// Mitsuba.
#pragma once

#include "kernels/bsdf/principled_lobes.h"
#include "scene/materials/principled.h"

namespace sheaf {

template <class L> struct PrincipledBsdf : PrincipledParameters<L> {
  using Closure = PrincipledClosure;
  static constexpr bool kIsSpecular = false, kIsAnisotropic = true;
  using F = typename L::Float;

  BsdfValue<L> evaluate(Vec3<L> wo, Vec3<L> wi) const;

  BsdfSample<L> sample(Vec3<L> wo, const Random4<L>& u) const;

  SHEAF_INLINE F squared_index(Vec3<L> wo) const { return sqr(select(wo.z > F(0.0f), this->eta, F(1.0f) / this->eta)); }

 private:
  /// Everything that depends only on the parameters and the outgoing direction. The surface is always seen from above:
  /// if wo lies inside, all directions are negated.
  struct View {
    F side;              ///< -1 if wo lies inside, else 1
    Mask<L> front;       ///< wo lies outside
    Vec3<L> wo;          ///< z >= 0
    F eta, inverse_eta;  ///< index of the far side over that of the near side
    F weight_o;          ///< Schlick weight of wo
    GgxDistribution<L> facets;
    F span_o;         ///< GgxTerms::span() of wo
    F brdf, bsdf;     ///< weights of the diffuse base and of refraction
    F sheen;          ///< weight of sheen
    Spectrum<L> hue;  ///< base color scaled to luminance 1; set only for tints
    /// reflectance at normal incidence of the part that uses Schlick's approximation
    Spectrum<L> schlick_color;
    F schlick_fraction;     ///< weight of that part
    F dielectric_fraction;  ///< weight of the part that uses the Fresnel equations
    /// square root of the base color, because light passes the surface twice
    Spectrum<L> transmittance;
    F max_transmittance;              ///< its largest component
    Clearcoat<L> coat;                ///< only where p_coat > 0
    F p_diffuse, p_coat, p_specular;  ///< probabilities of sampling the lobes

    SHEAF_INLINE View(const PrincipledParameters<L>& p, Vec3<L> direction)
        : side(select(direction.z < F(0.0f), F(-1.0f), F(1.0f))),
          front(direction.z > F(0.0f)),
          wo(direction * side),
          weight_o(schlick_weight(wo.z)),
          facets(burley_ggx<L>(p.roughness, p.anisotropic)),
          span_o(GgxTerms<L>::span(facets, wo)) {
      const F one(1.0f), zero(0.0f);
      const F reciprocal = one / p.eta, dielectric = one - p.metallic;
      eta = select(front, p.eta, reciprocal);
      inverse_eta = select(front, reciprocal, p.eta);
      brdf = select(front, dielectric * (one - p.spec_trans), zero);
      bsdf = select(wo.z > zero, dielectric * p.spec_trans, zero);
      sheen = select(brdf > zero, dielectric * p.sheen, zero);
      const auto& c = p.base_color;
      if (any(bsdf > zero)) transmittance = map_spectrum<L>(c, [](F x) SHEAF_LAMBDA_INLINE { return safe_sqrt(x); });
      max_transmittance = max_component(transmittance);

      const F f0 = normal_reflectance(p.eta);
      const F metal = select(front, p.metallic, zero), tinted = select(front, dielectric * p.spec_tint, zero);
      if (any((tinted > zero) | (sheen > zero))) hue = sheaf::hue(c, rec709_luminance(c, p.base_luminance));
      schlick_color = c * metal + hue * (f0 * tinted);
      schlick_fraction = metal + tinted;
      dielectric_fraction = select(front, dielectric * (one - p.spec_tint), bsdf);
      choose_probabilities(p, f0);
      if (any(p_coat > zero)) coat = Clearcoat<L>(p.clearcoat_gloss);
    }

    /// Sets the probabilities roughly in proportion to what each lobe scatters.
    SHEAF_INLINE void choose_probabilities(const PrincipledParameters<L>& p, F f0) {
      const F one(1.0f), zero(0.0f);
      const F fresnel = lerp(weight_o, f0, one);
      const F diffuse = fma(brdf, max_component(p.base_color), F(0.1f) * sheen * (weight_o + F(0.02f)));
      const F coated = select(front, p.clearcoat * Clearcoat<L>::fresnel(weight_o) * wo.z, zero);
      const F specular = max_component(schlick_color) * (one - weight_o) + schlick_fraction * weight_o +
                         dielectric_fraction * fresnel + bsdf * (one - fresnel) * max_transmittance;
      const F scale = one / max(diffuse + coated + specular, F(1e-20f));
      p_diffuse = diffuse * scale;
      p_coat = coated * scale;
      p_specular = specular * scale;
    }
  };

  /// Reflection and refraction at a facet whose normal has the cosine `cos_d` > 0 to wo.
  struct Facet {
    F cos_transmitted;      ///< of the refracted direction, positive; 0 at total internal reflection
    F weight;               ///< Schlick weight, by the angle on the less dense side
    Spectrum<L> reflected;  ///< reflected fraction
    F transmitted;          ///< transmitted fraction, before it is colored
    F reflects, transmits;  ///< their largest components; sampling is proportional to them

    SHEAF_INLINE Facet(const View& view, F cos_d) {
      const F one(1.0f), zero(0.0f), eta = view.eta;
      cos_transmitted = safe_sqrt(fma(fma(cos_d, cos_d, F(-1.0f)), sqr(view.inverse_eta), one));
      // Fresnel equations as in fresnel_dielectric(), over a common denominator.
      const F s_difference = cos_d - eta * cos_transmitted, s_sum = cos_d + eta * cos_transmitted;
      const F p_difference = eta * cos_d - cos_transmitted, p_sum = eta * cos_d + cos_transmitted;
      const F fresnel =
          F(0.5f) * (sqr(s_difference * p_sum) + sqr(p_difference * s_sum)) / max(sqr(s_sum * p_sum), F(1e-36f));
      weight = schlick_weight(select(eta > one, cos_d, cos_transmitted));
      const F white = fma(view.dielectric_fraction, fresnel, view.schlick_fraction * weight);
      const Spectrum<L> color = view.schlick_color * (one - weight) + Spectrum<L>(white);
      reflected = select<L>(eta != one, color, Spectrum<L>(zero));
      transmitted = view.bsdf * max(one - fresnel, zero);
      reflects = max_component(reflected);
      transmits = transmitted * view.max_transmittance;
    }
  };

  /// f |cos(wi)| and pdf; `wi` has been multiplied by `view.side`.
  SHEAF_INLINE BsdfValue<L> evaluate(const View& view, Vec3<L> wi) const {
    const F one(1.0f), zero(0.0f);
    const Mask<L> above = wi.z > zero;
    const F cos_i = abs(wi.z);
    // The length of the half vector is the denominator of the Jacobian of refraction (Walter et al. 2007, eq. 17).
    const Vec3<L> sum = view.wo + wi * select(above, one, view.eta);
    const F inverse_length = one / sqrt(max(length_squared(sum), F(1e-20f)));
    const Vec3<L> h = sum * copysign(inverse_length, sum.z);
    const F cos_d = dot(view.wo, h), cos_di = dot(wi, h);
    const Mask<L> possible =
        (cos_d > zero) & (view.wo.z > zero) & select(above, cos_di > zero, (cos_di < zero) & (wi.z < zero));
    const Facet facet(view, max(cos_d, zero));

    // Add specular reflection or refraction.
    const F bend = select(possible, select(above, F(0.25f), cos_d * abs(cos_di) * sqr(inverse_length)), zero);
    const GgxTerms<L> facets(view.facets, h, view.span_o, GgxTerms<L>::span(view.facets, wi));
    BsdfValue<L> value;
    value.f_cos =
        select<L>(above, facet.reflected, view.transmittance * facet.transmitted) * (facets.masked * bend * cos_i);
    const F chosen = select(above, facet.reflects, facet.transmits * sqr(view.eta)) /
                     max(facet.reflects + facet.transmits, F(1e-20f));
    value.pdf_solid_angle = view.p_specular * facets.density * bend * chosen;
    // Add the diffuse base, sheen and the clearcoat.
    add_diffuse(value, view, above & view.front, cos_i, cos_d);
    if (any(view.p_coat > zero)) {
      const auto coat = view.coat.terms(view.wo, wi, h);
      const Mask<L> lit = possible & above & view.front;
      const F strength = F(0.25f) * this->clearcoat * view.coat.fresnel(facet.weight) * view.wo.z * sqr(cos_i);
      value.f_cos = value.f_cos + Spectrum<L>(select(lit, strength * coat.masked, zero));
      // Jacobian of reflection 1 / (4 cos_d): the length of wo + wi is 2 cos_d.
      value.pdf_solid_angle += select(lit, view.p_coat * coat.density * F(0.5f) * h.z * inverse_length, zero);
    }
    return value;
  }

  SHEAF_INLINE void add_diffuse(BsdfValue<L>& value, const View& view, Mask<L> lit, F cos_i, F cos_d) const {
    const DiffuseAngles<L> angles{view.wo.z, view.weight_o, cos_i, schlick_weight(cos_i), this->roughness * sqr(cos_d)};
    const F shape = any(this->flatness > F(0.0f)) ? angles.diffuse(this->flatness) : angles.diffuse();
    const F cosine = select(lit, cos_i, F(0.0f)), lambert = cosine * F(kInvPi);
    value.f_cos = value.f_cos + this->base_color * (view.brdf * lambert * shape);
    value.pdf_solid_angle += view.p_diffuse * lambert;
    if (any(view.sheen > F(0.0f)))
      value.f_cos = value.f_cos + lerp(this->sheen_tint, Spectrum<L>(F(1.0f)), view.hue) *
                                      (view.sheen * schlick_weight(cos_d) * cosine);
  }
};

template <> struct BsdfOf<PrincipledClosure> : BsdfTag<PrincipledBsdf> {};

}  // namespace sheaf
