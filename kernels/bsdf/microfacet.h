// Microfacet distributions: distribution of normals, masking-shadowing, and sampling.
//
// Both distributions have density(), Smith's masking-shadowing terms, and sampling of visible normals (Heitz and d'Eon,
// "Importance Sampling Microfacet-Based BSDFs using the Distribution of Visible Normals", EGSR 2014). Directions are
// unit vectors in the shading frame; m is a microfacet normal. No function divides by the cosine of a direction, so
// grazing directions are safe.
#pragma once

#include "core/sampling/warp.h"

namespace sheaf {

/// Range to which roughness is clamped. Smaller values exceed single precision, larger ones are physically meaningless.
inline constexpr float kMinAlpha = 1e-4f, kMaxAlpha = 1e3f;

/// Functions shared by the distributions. Model has density(m), smith_g1_over_cos(v) and sample_visible(wo, u1, u2).
template <class L, class Model> struct MicrofacetDistribution {
  using F = typename L::Float;
  /// roughness along x and along y, in [kMinAlpha, kMaxAlpha]: the root mean square slope times sqrt(2)
  F alpha_u, alpha_v;

  SHEAF_INLINE MicrofacetDistribution(F u, F v)
      : alpha_u(clamp(u, F(kMinAlpha), F(kMaxAlpha))), alpha_v(clamp(v, F(kMinAlpha), F(kMaxAlpha))) {}

  /// Smith's masking G1: fraction of the facets with normal m that are visible from v, on either side of the surface. 0
  /// if the cosines of v to m and to the surface normal have different signs.
  SHEAF_INLINE F smith_g1(Vec3<L> v, Vec3<L> m) const { return smith_g1_over_cos(v, m) * abs(v.z); }

  /// smith_g1() / |v.z|; finite at grazing directions.
  SHEAF_INLINE F smith_g1_over_cos(Vec3<L> v, Vec3<L> m) const {
    return select(dot(v, m) * v.z > F(0.0f), model().smith_g1_over_cos(v), F(0.0f));
  }

  /// Solid-angle pdf of m for sample_visible(), D(m) G1(wo) |wo.m| / wo.z, for wo.z > 0.
  SHEAF_INLINE F pdf_visible(Vec3<L> wo, Vec3<L> m) const {
    return model().density(m) * smith_g1_over_cos(wo, m) * abs(dot(wo, m));
  }

 protected:
  SHEAF_INLINE const Model& model() const { return static_cast<const Model&>(*this); }
  /// Squared length of the projection of v onto the surface, scaled by the roughness.
  SHEAF_INLINE F projected_roughness2(Vec3<L> v) const { return sqr(alpha_u * v.x) + sqr(alpha_v * v.y); }
};

/// The distribution of Trowbridge and Reitz 1975, called GGX by Walter et al. 2007.
template <class L> struct GgxDistribution : MicrofacetDistribution<L, GgxDistribution<L>> {
  using Base = MicrofacetDistribution<L, GgxDistribution<L>>;
  using F = typename L::Float;
  using Base::Base, Base::smith_g1_over_cos;

  /// D(m): facet area per surface area and solid angle around m; 0 below the surface (Walter et al. 2007, equation 33,
  /// with two alphas).
  SHEAF_INLINE F density(Vec3<L> m) const {
    const F product = this->alpha_u * this->alpha_v;
    const F e2 = sqr(m.x * this->alpha_v) + sqr(m.y * this->alpha_u) + sqr(m.z * product);
    return select(m.z > F(0.0f), F(kInvPi) * product * product * product / (e2 * e2), F(0.0f));
  }

  /// G1(v) / |v.z|, independent of the facet (Heitz 2014, equation 72).
  SHEAF_INLINE F smith_g1_over_cos(Vec3<L> v) const {
    return F(2.0f) / (abs(v.z) + sqrt(v.z * v.z + this->projected_roughness2(v)));
  }

  /// Samples a normal visible from wo, wo.z > 0, for u1 and u2 in [0, 1) (Dupuy and Benyoub, "Sampling Visible GGX
  /// Normals with Spherical Caps", HPG 2023).
  SHEAF_INLINE Vec3<L> sample_visible(Vec3<L> wo, F u1, F u2) const {
    const Vec3<L> w = normalize<L>({wo.x * this->alpha_u, wo.y * this->alpha_v, wo.z});
    const F depth = u2 * (F(1.0f) + w.z);  // of the point on the cap, below the top of the sphere
    const F r = safe_sqrt(depth * (F(2.0f) - depth));
    const auto angle = sincos_2pi<L>(u1);
    return normalize<L>(
        {this->alpha_u * fma(r, angle.cos, w.x), this->alpha_v * fma(r, angle.sin, w.y), F(1.0f) - depth + w.z});
  }
};

/// Polynomial c0 + c1 x + c2 x^2 + ... of up to eight terms, evaluated by Estrin's scheme (1960).
template <class F, class... C> SHEAF_INLINE F polynomial(F x, C... c) {
  static_assert(sizeof...(c) <= 8);
  const float terms[8] = {c...};
  const F x2 = x * x;
  const auto pair = [&](int i) SHEAF_LAMBDA_INLINE { return fma(x, F(terms[i + 1]), F(terms[i])); };
  if constexpr (sizeof...(c) <= 4)
    return fma(x2, pair(2), pair(0));
  else
    return fma(x2 * x2, sizeof...(c) <= 6 ? pair(4) : fma(x2, pair(6), pair(4)), fma(x2, pair(2), pair(0)));
}

/// exp(-x) for x >= 0, relative error below 2e-7 (1 + x). About 1e-38 for x >= 87 and for NaN.
template <class F> SHEAF_INLINE F exp_minus(F x) {
  const F y = max(x * F(-1.44269504f), F(-125.0f));
  const F shifted = y + F(12582912.0f);  // 1.5 2^23: the low bits hold y rounded to an integer
  const F f = y - (shifted - F(12582912.0f));
  const F fraction = polynomial(f, 1.00000007f, 0.69314697f, 0.24022119f, 0.05550713f, 0.00967556f, 0.00132765f);
  return bits_float(float_bits(fraction) + (float_bits(shifted) << 23));
}

/// log2(x) for normal x > 0, absolute error below 1e-6.
template <class F> SHEAF_INLINE F log2_positive(F x) {
  using U = decltype(float_bits(x));
  const U sqrt_half(0x3f3504f3u), bits = float_bits(x) + (U(0x3f800000u) - sqrt_half);
  const F t = bits_float((bits & U(0x7fffffu)) + sqrt_half) - F(1.0f);
  const F slope =
      polynomial(t, 1.44269973f, -0.72137589f, 0.48046485f, -0.3589611f, 0.29726456f, -0.2727054f, 0.17063694f);
  return fma(t, slope, to_float(bits >> 23) - F(127.0f));
}

/// The distribution of Beckmann and Spizzichino 1963: normally distributed slopes.
template <class L> struct BeckmannDistribution : MicrofacetDistribution<L, BeckmannDistribution<L>> {
  using Base = MicrofacetDistribution<L, BeckmannDistribution<L>>;
  using F = typename L::Float;
  using Base::Base, Base::smith_g1_over_cos;

  /// D(m): facet area per surface area and solid angle around m; 0 below the surface (Walter et al. 2007, equation 25,
  /// with two alphas).
  SHEAF_INLINE F density(Vec3<L> m) const {
    const F product = this->alpha_u * this->alpha_v, z2 = max(m.z * m.z, F(1e-12f));
    const F inverse = F(1.0f) / (product * z2);
    const F slope2 = (sqr(m.x * this->alpha_v) + sqr(m.y * this->alpha_u)) * inverse * (z2 * inverse);
    return select(m.z > F(0.0f), F(kInvPi) * exp_minus(slope2) * (product * inverse) * inverse, F(0.0f));
  }

  /// G1(v) / |v.z|, independent of the facet (Walter et al. 2007, equation 26).
  SHEAF_INLINE F smith_g1_over_cos(Vec3<L> v) const {
    const F inverse_s = F(1.0f) / stretched_sine(v);
    const Ratio g = shadowing(abs(v.z) * inverse_s);
    return g.over / g.under * inverse_s;
  }

  /// Samples a normal visible from wo, wo.z > 0, for u1 and u2 in [0, 1). Slopes are sampled in the frame where wo lies
  /// in the xz plane and the roughness is 1 (Heitz and d'Eon 2014): y from a normal distribution, x by inverting its
  /// CDF.
  SHEAF_INLINE Vec3<L> sample_visible(Vec3<L> wo, F u1, F u2) const {
    const F s = stretched_sine(wo), inverse_s = F(1.0f) / s;
    const F cos_phi = select(s > F(kMinSine), wo.x * this->alpha_u * inverse_s, F(1.0f));
    const F sin_phi = wo.y * this->alpha_v * inverse_s;
    const F along = sample_visible_slope(abs(wo.z) * inverse_s, u1), across = sample_slope(u2);
    return normalize<L>({this->alpha_u * (sin_phi * across - cos_phi * along),
                         -this->alpha_v * (sin_phi * along + cos_phi * across), F(1.0f)});
  }

 private:
  static constexpr float kMinSine = 1e-10f;  ///< smaller sines count as normal incidence
  static constexpr float kMaxSlope = 4.2f;   ///< 3e-9 of the facets have larger slopes
  static constexpr float kSqrtPi = 1.77245385f;
  struct Ratio {
    F over, under;
  };

  SHEAF_INLINE F stretched_sine(Vec3<L> v) const { return max(sqrt(this->projected_roughness2(v)), F(kMinSine)); }

  /// G1 / a, where a is the cosine over the stretched sine: 2 / (a + a erf(a) + exp(-a^2) / sqrt(pi)), with an error of
  /// 6e-7. The rational approximation holds up to 3.2; above, G1 is 1 to within 2e-7.
  static SHEAF_INLINE Ratio shadowing(F a) {
    const F t = min(a, F(3.2f));
    return {
        select(a < F(3.2f), polynomial(t, 3.54491056f, 0.1430688f, 1.02810747f, 0.12289164f, 0.11172969f), F(1.0f)),
        select(a < F(3.2f), polynomial(t, 1.0f, 1.81287994f, 1.36056347f, 0.59474668f, 0.20084562f, 0.10607205f), a)};
  }

  /// Solves erf(x) = 2 u - 1 with a relative error below 2e-5. u is clamped to at least 1.25e-8 (from either end).
  static SHEAF_INLINE F sample_slope(F u) {
    const F w = -log2_positive(max(u * (F(4.0f) - F(4.0f) * u), F(5e-8f)));
    return (F(2.0f) * u - F(1.0f)) * polynomial(w, 0.88623936f, 0.20839367f, 0.02584452f, 0.00182318f) /
           polynomial(w, 1.0f, 0.05370539f, 0.01320931f, 0.00013266f);
  }

  /// Samples a slope x with density proportional to max(cot - x, 0) exp(-x^2), the slopes visible from a direction with
  /// cosine over stretched sine `cot`. The initial guess assumes that the density over erf(x) is linear. Two Halley
  /// steps then give the CDF to within 1e-6; the error of the density is at most 6e-4 and typically 2e-5.
  static SHEAF_INLINE F sample_visible_slope(F cot, F u) {
    const F one(1.0f), two(2.0f), half(0.5f), target_u = max(u, F(2.5e-8f)), end = min(cot, F(kMaxSlope));
    // `whole` is 1 + erf(end), never more; `tilt` the slope of the density; `b` 1 + erf(x) of the guess.
    const F whole = two - exp_minus(end * end) * polynomial(end, 1.0000612f, -1.01125963f, 0.61873312f, -0.21540324f,
                                                            0.03864413f, -0.00275649f);
    const F tilt = one + clamp(fma(cot, F(-0.1f), F(1.1f)), F(0.0f), one);
    const F b = whole * two * target_u / (tilt + safe_sqrt(tilt * tilt - F(4.0f) * (tilt - one) * target_u));
    const F w = fma(to_float(float_bits(max(b * (two - b), F(3e-8f)))), F(-1.1920929e-7f), F(126.957f));
    F x = (b - one) * polynomial(w, 0.87965424f, 0.18074398f, -0.00228547f);
    // Both sides are multiplied by the denominators of G1 and of erfc(|x|) exp(x^2).
    const Ratio g = shadowing(cot);
    const F cumulative_scale = F(0.5f * kSqrtPi) * cot * g.over, target = F(kSqrtPi) * g.under * target_u;
    for (int step = 0; step < 2; ++step) {
      x = clamp(x, F(-kMaxSlope), end);
      const F a = abs(x), e = exp_minus(x * x);
      const F tail = e * polynomial(a, 1.0f, 0.96736041f, 0.4336841f, 0.08200602f);
      const F scale = polynomial(a, 1.0f, 2.09573111f, 1.79857103f, 0.76745734f, 0.14541074f);
      const F excess = fma(cumulative_scale, select(x < F(0.0f), tail, fma(two, scale, -tail)),
                           fma(half * g.over, e, -target) * scale);
      const F visible = max(cot - x, F(1e-6f)), first = scale * g.over * visible * visible * e;
      const F second = half * excess * fma(two * x, visible, one);
      x -= excess * visible / max(first + second, F(0.3f) * first);
    }
    return clamp(x, F(-kMaxSlope), end);
  }
};

/// Reflection by the microfacets that mirror wo into wi.
template <class L> struct FacetReflection {
  typename L::Float pdf_solid_angle;  ///< of wi by visible normals: D(m) G1(wo) / (4 wo.z); 0: none
  /// G1(wi); the BRDF times |cos(wi)| is pdf * shadowing * Fresnel reflectance
  typename L::Float shadowing;
  typename L::Float cos_facet;  ///< wo . m
};

/// The pdf is 0 unless wo and wi are both above the surface.
template <class L, template <class> class Distribution>
SHEAF_INLINE FacetReflection<L> evaluate_reflection(const Distribution<L>& facets, Vec3<L> wo, Vec3<L> wi) {
  using F = Float<L>;
  const Vec3<L> m = normalize(wo + wi);
  const F pdf = F(0.25f) * facets.density(m) * facets.smith_g1_over_cos(wo);
  const auto valid = (wo.z > F(0.0f)) & (wi.z > F(0.0f)) & (pdf > F(0.0f));
  return {select(valid, pdf, F(0.0f)), wi.z * facets.smith_g1_over_cos(wi), select(valid, dot(wo, m), F(1.0f))};
}

/// A direction sampled by reflection at a visible normal, with its evaluate_reflection() value.
template <class L> struct FacetReflectionSample : FacetReflection<L> { Vec3<L> wi; };

/// Samples a reflected direction, for u1 and u2 in [0, 1). The pdf is 0 if wo or the direction is below the surface.
template <class L, template <class> class Distribution>
SHEAF_INLINE FacetReflectionSample<L> sample_reflection(const Distribution<L>& facets, Vec3<L> wo, Float<L> u1,
                                                        Float<L> u2) {
  using F = Float<L>;
  const Vec3<L> m = facets.sample_visible(wo, u1, u2);
  const F cos_facet = dot(wo, m);
  const Vec3<L> wi = m * (cos_facet + cos_facet) - wo;
  const F pdf = F(0.25f) * facets.density(m) * facets.smith_g1_over_cos(wo);
  const auto valid = (wo.z > F(0.0f)) & (wi.z > F(0.0f)) & (cos_facet > F(0.0f)) & (pdf > F(0.0f));
  return {{select(valid, pdf, F(0.0f)), wi.z * facets.smith_g1_over_cos(wi), select(valid, cos_facet, F(1.0f))}, wi};
}

}  // namespace sheaf
