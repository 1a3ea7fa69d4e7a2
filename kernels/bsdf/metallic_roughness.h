// The metallic-roughness material of glTF 2.0 (appendix B of the specification), with KHR_materials_ior, _specular,
// _transmission, _anisotropy, _sheen and _clearcoat.
//
//   base  = metallic metal + (1 - metallic) ((1 - w max F) ((1 - t) base_color / pi + t base_color transmission)
//                                            + w F facets)
//   cloth = sheen_color sheen + (1 - max(sheen_color) E) base
//   f     = k F_k facets_k + (1 - k F_k(wo)) (1 - k F_k(wi)) cloth
// `facets` is the GGX lobe with height-correlated masking (Heitz 2014), `transmission` the same lobe mirrored to the
// other side, F Schlick's approximation at the facets, `w` the weight of specular reflection, `t` transmission, `E` the
// larger of the sheen's albedos for wo and wi, `k` the clearcoat and F_k its reflectance for an index of 1.5, at the
// facets in the first term and at the surface in the second one.
//
// Three terms differ from the sample formulas of the extensions, which are not reciprocal or gain energy: the clearcoat
// attenuates light on its way in and on its way out (KHR_materials_clearcoat: only once, by the cosine of wo),
// transmission does not clip facets (KHR_materials_transmission), and SheenLobe limits the albedo of the sheen.
//
// As stated in appendix B, the dielectric does not conserve energy: its diffuse part is attenuated at the facet that
// reflects wi into wo, but not by what other facets reflect. The albedo of a white one is 1 at normal incidence and
// rises at grazing incidence, to 1.8 for a roughness of 0.1 and to 1.2 for 0.5. With a base color below 0.95, a closed
// surface loses energy.
#pragma once

#include "kernels/bsdf/principled_lobes.h"
#include "kernels/bsdf/sheen.h"
#include "scene/materials/metallic_roughness.h"

namespace sheaf {

template <class L> struct MetallicRoughnessBsdf : MetallicRoughnessParameters<L> {
  using Closure = MetallicRoughnessClosure;
  static constexpr bool kIsSpecular = false, kIsAnisotropic = true;
  using F = typename L::Float;
  /// Minimum roughness alpha of the facets. Smoother surfaces would be delta lobes.
  static constexpr float kMinFacetAlpha = 1e-3f;

  BsdfValue<L> evaluate(Vec3<L> wo, Vec3<L> wi) const;

  BsdfSample<L> sample(Vec3<L> wo, const Random4<L>& u) const;

 private:
  /// A GGX lobe with height-correlated masking, for one outgoing direction.
  struct FacetLobe {
    GgxDistribution<L> facets;
    F cos_o;   ///< cosine of wo to the normal
    F root_o;  ///< root() of wo

    SHEAF_INLINE FacetLobe(F alpha_u, F alpha_v, Vec3<L> wo)
        : facets(alpha_u, alpha_v), cos_o(wo.z), root_o(root(wo)) {}

    struct Value {
      F f_cos;  ///< for a reflectance of 1
      F pdf;    ///< of reflection at visible normals
    };
    /// For wi above the surface, with the half vector `h`.
    SHEAF_INLINE Value evaluate(Vec3<L> wi, Vec3<L> h) const {
      const F half_density = F(0.5f) * facets.density(h), one(1.0f);
      const F correlated = max(fma(wi.z, root_o, cos_o * root(wi)), F(1e-20f));
      return {half_density * wi.z * (one / correlated), half_density * (one / (cos_o + root_o))};
    }

   private:
    /// Length of v with its projection onto the surface scaled by the roughness.
    SHEAF_INLINE F root(Vec3<L> v) const {
      return sqrt(v.z * v.z + sqr(facets.alpha_u * v.x) + sqr(facets.alpha_v * v.y));
    }
  };

  static SHEAF_INLINE F alpha_of(F roughness) { return max(roughness * roughness, F(kMinFacetAlpha)); }

  /// Everything that depends only on the parameters and the outgoing direction. Directions are mirrored so that a thin
  /// wall is seen from above, and turned so that the x axis is the direction of larger roughness.
  struct View {
    F side;              ///< factor of z; -1 if a thin wall is seen from below
    SinCos<L> rotation;  ///< of the angle from the tangent to the x axis; used only where surfaces are anisotropic
    Mask<L> is_rotated;
    Vec3<L> wo;
    FacetLobe lobe;
    Spectrum<L> normal_reflectance;  ///< of metal and dielectric at normal incidence
    F grazing_reflectance;
    F passes, passes_slope;  ///< the fraction that enters the dielectric is passes - passes_slope * Schlick weight
    F clear_o;               ///< transmittance of the clearcoat along wo
    F max_sheen;             ///< largest component of the sheen's color
    SheenLobe<L> sheen;      ///< set only if there is sheen
    F sheen_albedo;          ///< for wo
    F p_diffuse, p_specular, p_transmit, p_sheen, p_coat;  ///< probabilities of sampling the lobes

    SHEAF_INLINE View(const MetallicRoughnessBsdf& p, Vec3<L> direction)
        : side(select((p.is_thin != Uint<L>(0u)) & (direction.z < F(0.0f)), F(-1.0f), F(1.0f))),
          rotation(rotation_of(p)),
          is_rotated(p.anisotropy > F(0.0f)),
          wo(to_local(direction)),
          lobe(lobe_of(p, wo)) {
      const F zero(0.0f), one(1.0f), dielectric = one - p.metallic, specular = dielectric * p.specular;
      const auto scaled = [&p](F factor) SHEAF_LAMBDA_INLINE { return clamp(factor * p.f0, F(0.0f), F(1.0f)); };
      const Spectrum<L> f0 = map_spectrum<L>(p.specular_color, scaled);
      normal_reflectance = p.base_color * p.metallic + f0 * specular;
      grazing_reflectance = p.metallic + specular;
      const F max_f0 = max_component(f0);
      passes = fma(-specular, max_f0, dielectric);
      passes_slope = specular * (one - max_f0);

      max_sheen = max_component(p.sheen_color);
      sheen_albedo = zero;
      if (any(max_sheen > zero)) {
        sheen = SheenLobe<L>(p.sheen_roughness);
        sheen_albedo = sheen.albedo(wo.z);
      }
      const F weight_o = schlick_weight(wo.z);
      clear_o = one - p.clearcoat * Clearcoat<L>::fresnel(weight_o);
      choose_probabilities(p, weight_o);
    }

    /// Sets the probabilities roughly in proportion to what each lobe scatters. `weight_o`: Schlick weight of wo.
    SHEAF_INLINE void choose_probabilities(const MetallicRoughnessBsdf& p, F weight_o) {
      const F one(1.0f), cloth = clear_o * max_sheen * min(sheen_albedo, one), base = clear_o - cloth;
      const F color = base * max_component(p.base_color);
      // Light enters the facets at other angles than the surface: neither lobe gets a probability near 0.
      const F diffuse = color * passes * (one - p.transmission);
      const F transmitted = color * p.transmission * fma(F(-0.9f) * passes_slope, weight_o, passes);
      const F reflected = base * lerp(weight_o, max_component(normal_reflectance), grazing_reflectance);
      const F coated = one - clear_o;
      const F scale = one / max(diffuse + transmitted + reflected + cloth + coated, F(1e-20f));
      p_diffuse = diffuse * scale;
      p_transmit = transmitted * scale;
      p_specular = reflected * scale;
      p_sheen = cloth * scale;
      p_coat = coated * scale;
    }

    static SHEAF_INLINE SinCos<L> rotation_of(const MetallicRoughnessBsdf& p) {
      if (!any(p.anisotropy > F(0.0f))) return {F(0.0f), F(1.0f)};
      const F revolutions = p.anisotropy_rotation * F(0.5f * kInvPi);
      return sincos_2pi<L>(revolutions - floor(revolutions));
    }

    /// KHR_materials_anisotropy
    static SHEAF_INLINE FacetLobe lobe_of(const MetallicRoughnessBsdf& p, Vec3<L> wo) {
      const F alpha = alpha_of(p.roughness);
      return FacetLobe(lerp(sqr(p.anisotropy), alpha, F(1.0f)), alpha, wo);
    }

    SHEAF_INLINE Vec3<L> to_local(Vec3<L> v) const {
      v.z = v.z * side;
      if (!any(is_rotated)) return v;
      return {fma(rotation.cos, v.x, rotation.sin * v.y), fma(rotation.cos, v.y, -(rotation.sin * v.x)), v.z};
    }
    SHEAF_INLINE Vec3<L> to_shading_frame(Vec3<L> v) const {
      v.z = v.z * side;
      if (!any(is_rotated)) return v;
      return {fma(rotation.cos, v.x, -(rotation.sin * v.y)), fma(rotation.cos, v.y, rotation.sin * v.x), v.z};
    }
  };

  /// f |cos(wi)| and pdf; `wi` is local to the view.
  SHEAF_INLINE BsdfValue<L> evaluate(const View& view, Vec3<L> wi) const {
    const F zero(0.0f), one(1.0f);
    const Mask<L> above = wi.z > zero;
    const Vec3<L> mirrored{wi.x, wi.y, abs(wi.z)};
    const Vec3<L> sum = view.wo + mirrored;
    const Vec3<L> h = sum * (one / sqrt(max(length_squared(sum), F(1e-20f))));
    const F weight = schlick_weight(dot(view.wo, h));

    // Evaluate diffuse and specular reflection, and transmission
    const auto facets = view.lobe.evaluate(mirrored, h);
    const F lambert = mirrored.z * F(kInvPi), passes = max(fma(-view.passes_slope, weight, view.passes), zero);
    const Spectrum<L> fresnel =
        view.normal_reflectance * (one - weight) + Spectrum<L>(view.grazing_reflectance * weight);
    BsdfValue<L> value;
    value.f_cos = fresnel * select(above, facets.f_cos, zero) +
                  this->base_color *
                      (passes * select(above, (one - this->transmission) * lambert, this->transmission * facets.f_cos));
    value.pdf_solid_angle =
        select(above, fma(view.p_diffuse, lambert, view.p_specular * facets.pdf), view.p_transmit * facets.pdf);

    // Add the layers above
    if (any(view.max_sheen > zero)) add_sheen(value, view, above, mirrored.z, h);
    if (any(this->clearcoat > zero)) add_clearcoat(value, view, above, mirrored, h, weight);

    const Mask<L> lit = (view.wo.z > zero) & (mirrored.z > zero);
    value.f_cos = select<L>(lit, value.f_cos, Spectrum<L>(zero));
    value.pdf_solid_angle = select(lit, value.pdf_solid_angle, zero);
    return value;
  }

  SHEAF_INLINE void add_sheen(BsdfValue<L>& value, const View& view, Mask<L> above, F cos_i, Vec3<L> h) const {
    const F zero(0.0f), one(1.0f), albedo = max(view.sheen_albedo, view.sheen.albedo(cos_i));
    const F scattered = select(above, view.sheen.evaluate(view.wo.z, cos_i, h, albedo), zero);
    value.f_cos = value.f_cos * fma(-view.max_sheen, min(albedo, one), one) + this->sheen_color * scattered;
    value.pdf_solid_angle += select(above, view.p_sheen * F(0.5f * kInvPi), zero);
  }

  /// `weight`: Schlick weight at the facets.
  SHEAF_INLINE void add_clearcoat(BsdfValue<L>& value, const View& view, Mask<L> above, Vec3<L> wi, Vec3<L> h,
                                  F weight) const {
    const F zero(0.0f), one(1.0f), alpha = alpha_of(this->clearcoat_roughness);
    const auto coat = FacetLobe(alpha, alpha, view.wo).evaluate(wi, h);
    const F clear_i = one - this->clearcoat * Clearcoat<L>::fresnel(schlick_weight(wi.z));
    const F reflected = select(above, this->clearcoat * Clearcoat<L>::fresnel(weight) * coat.f_cos, zero);
    value.f_cos = value.f_cos * (view.clear_o * clear_i) + Spectrum<L>(reflected);
    value.pdf_solid_angle += select(above, view.p_coat * coat.pdf, zero);
  }
};

template <> struct BsdfOf<MetallicRoughnessClosure> : BsdfTag<MetallicRoughnessBsdf> {};

}  // namespace sheaf
