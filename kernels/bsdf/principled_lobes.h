// Building blocks of the principled BSDFs and the Disney BRDF: perceptual roughness, tints, diffuse reflection with
// retro-reflection, and the clearcoat.
//
// Sources: Burley, "Physically Based Shading at Disney" (SIGGRAPH 2012 course notes) and "Extending the Disney BRDF to
// a BSDF with Integrated Subsurface Scattering" (SIGGRAPH 2015 course notes).
#pragma once

#include "kernels/bsdf/bsdf.h"
#include "kernels/bsdf/fresnel.h"
#include "kernels/bsdf/microfacet.h"

namespace sheaf {

/// Microfacet distribution for the perceptual parameters `roughness` and `anisotropic` in [0, 1] (Burley 2012, section
/// 5.4).
template <class L> SHEAF_INLINE GgxDistribution<L> burley_ggx(Float<L> roughness, Float<L> anisotropic) {
  using F = Float<L>;
  constexpr float kMinBurleyAlpha = 0.001f;
  const F alpha = roughness * roughness;
  if (!any(anisotropic > F(0.0f))) return {max(F(kMinBurleyAlpha), alpha), max(F(kMinBurleyAlpha), alpha)};
  const F aspect = sqrt(F(1.0f) - F(0.9f) * anisotropic);
  return {max(F(kMinBurleyAlpha), alpha / aspect), max(F(kMinBurleyAlpha), alpha * aspect)};
}

/// GgxDistribution::density() and smith_g1_over_cos() combined, with a single division.
template <class L> struct GgxTerms {
  using F = typename L::Float;
  F density;  ///< D(h) G1(wo) / wo.z
  F masked;   ///< density times G1(wi) / |wi.z|

  /// v.z| plus the length of v scaled by the roughness: 2 |v.z| / G1(v).
  static SHEAF_INLINE F span(const GgxDistribution<L>& facets, Vec3<L> v) {
    return abs(v.z) + sqrt(v.z * v.z + sqr(facets.alpha_u * v.x) + sqr(facets.alpha_v * v.y));
  }

  /// Requires h.z >= 0; `span_o` and `span_i` are span() of wo and wi.
  SHEAF_INLINE GgxTerms(const GgxDistribution<L>& facets, Vec3<L> h, F span_o, F span_i) {
    const F product = facets.alpha_u * facets.alpha_v;
    const F e = sqr(h.x * facets.alpha_v) + sqr(h.y * facets.alpha_u) + sqr(h.z * product);
    // Opposite directions have no half vector: e is 0, and the result must stay finite.
    const F common = F(2.0f * kInvPi) * product * product * product / max(e * e * (span_o * span_i), F(1e-33f));
    density = common * span_i;
    masked = F(2.0f) * common;
  }
};

/// Samples a direction around +z with pdf cos(theta) / pi. Like sample_visible(), it takes the azimuth from u1, so that
/// the two share its sine and cosine.
template <class L> SHEAF_INLINE Vec3<L> cosine_hemisphere_polar(Float<L> u1, Float<L> u2) {
  const auto angle = sincos_2pi<L>(u1);
  const Float<L> r = sqrt(u2);
  return {r * angle.cos, r * angle.sin, sqrt(Float<L>(1.0f) - u2)};
}

/// Weight of white in Schlick's approximation of Fresnel reflectance, (1 - cos_theta)^5 (Schlick 1994).
template <class F> SHEAF_INLINE F schlick_weight(F cos_theta) {
  const F m = clamp(F(1.0f) - cos_theta, F(0.0f), F(1.0f)), m2 = m * m;
  return m2 * m2 * m;
}

/// The luminance `known` unless it is 0. Otherwise that of the first three components as linear Rec.709.
template <class L> SHEAF_INLINE Float<L> rec709_luminance(const Spectrum<L>& c, Float<L> known) {
  using F = Float<L>;
  return select(known > F(0.0f), known, fma(c.c0, F(0.212671f), fma(c.c1, F(0.715160f), c.c2 * F(0.072169f))));
}

/// As rec709_luminance(), with the approximate coefficients of Burley's 2012 notes.
template <class L> SHEAF_INLINE Float<L> burley_luminance(const Spectrum<L>& c, Float<L> known) {
  using F = Float<L>;
  return select(known > F(0.0f), known, fma(c.c0, F(0.3f), fma(c.c1, F(0.6f), c.c2 * F(0.1f))));
}

/// Scales `color` to luminance 1, given its luminance; white for black.
template <class L> SHEAF_INLINE Spectrum<L> hue(const Spectrum<L>& color, Float<L> luminance) {
  using F = Float<L>;
  const Mask<L> lit = luminance > F(0.0f);
  return select<L>(lit, color * (F(1.0f) / select(lit, luminance, F(1.0f))), Spectrum<L>(F(1.0f)));
}

/// a + t (b - a) in every component.
template <class L> SHEAF_INLINE Spectrum<L> lerp(Float<L> t, const Spectrum<L>& a, const Spectrum<L>& b) {
  return {lerp(t, a.c0, b.c0), lerp(t, a.c1, b.c1), lerp(t, a.c2, b.c2), lerp(t, a.c3, b.c3)};
}

/// Arguments of the diffuse lobe: cosines of a pair of directions above the surface, and their Schlick weights.
template <class L> struct DiffuseAngles {
  using F = typename L::Float;
  F cos_o, weight_o;  ///< of the outgoing direction to the normal
  F cos_i, weight_i;  ///< of the incident direction to the normal
  F retro;            ///< roughness times the squared cosine between wo and the half vector

  /// pi f / base color: dark edges at low roughness, bright ones at high roughness (Burley 2012, section 5.3).
  SHEAF_INLINE F diffuse() const {
    const F excess = F(2.0f) * retro - F(0.5f);
    return fma(excess, weight_o, F(1.0f)) * fma(excess, weight_i, F(1.0f));
  }

  /// Blends in an approximation of subsurface scattering (after Hanrahan and Krueger 1993) with weight `flatness`.
  SHEAF_INLINE F diffuse(F flatness) const {
    const F excess = retro - F(1.0f);
    const F both = fma(excess, weight_o, F(1.0f)) * fma(excess, weight_i, F(1.0f));
    const F flat = F(1.25f) * fma(both, F(1.0f) / max(cos_o + cos_i, F(1e-6f)) - F(0.5f), F(0.5f));
    return lerp(flatness, diffuse(), flat);
  }
};

/// The clearcoat, a second specular lobe on top: the generalized Trowbridge-Reitz distribution with exponent 1 (long
/// tails), an index of refraction of 1.5, and a separate Smith term (Burley 2012, section 5.4 and appendix B).
template <class L> struct Clearcoat {
  using F = typename L::Float;
  F alpha2{}, log_alpha2{};  ///< squared roughness, below 1, and its logarithm

  Clearcoat() = default;
  /// `gloss` in [0, 1].
  SHEAF_INLINE explicit Clearcoat(F gloss) : alpha2(sqr(lerp(gloss, F(0.1f), F(0.001f)))), log_alpha2(log(alpha2)) {}

  /// Reflectance, given the Schlick weight for the angle to the facet.
  static SHEAF_INLINE F fresnel(F weight) { return fma(F(0.96f), weight, F(0.04f)); }

  /// Samples a normal m with the solid-angle pdf D(m) m.z (appendix B, equation 5).
  SHEAF_INLINE Vec3<L> sample(F u1, F u2) const {
    const F sin2 = (exp(u2 * log_alpha2) - alpha2) / (F(1.0f) - alpha2);
    const F sin_theta = safe_sqrt(sin2);
    const auto angle = sincos_2pi<L>(u1);
    return {sin_theta * angle.cos, sin_theta * angle.sin, safe_sqrt(F(1.0f) - sin2)};
  }

  /// D of a half vector with Smith's terms, computed with a single division.
  struct Terms {
    F density;  ///< D(h) (appendix B, equation 4)
    F masked;   ///< D(h) G1(wo) G1(wi) / |wo.z wi.z|
  };
  SHEAF_INLINE Terms terms(Vec3<L> wo, Vec3<L> wi, Vec3<L> h) const {
    const F spans = span(wo) * span(wi);
    const F e = max(h.x * h.x + h.y * h.y + alpha2 * h.z * h.z, F(1e-9f));
    const F common = (alpha2 - F(1.0f)) * F(kInvPi) / (log_alpha2 * e * spans);
    return {common * spans, F(4.0f) * common};
  }

 private:
  /// As GgxTerms::span(), for alpha = 0.25.
  static SHEAF_INLINE F span(Vec3<L> v) { return abs(v.z) + sqrt(fma(F(0.9375f), v.z * v.z, F(0.0625f))); }
};

}  // namespace sheaf
