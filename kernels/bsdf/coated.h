// A smooth dielectric coat over an opaque closure (Weidlich and Wilkie, "Arbitrarily Layered Micro-Facet Surfaces",
// GRAPHITE 2007, section 4): light is mirrored at the coat, or enters it bent, is scattered by what is below, absorbed
// along its two ways through the coat (Bouguer, Lambert and Beer), and leaves bent. What the coat sends back down again
// is lost. With o, i the directions within and R the Fresnel term,
//   f = (1 - R(wo)) (1 - R(wi)) exp(-sigma_a thickness (1 / cos o + 1 / cos i)) f_nested(o, i) / eta^2.
#pragma once

#include "core/distribution.h"
#include "kernels/bsdf/coatable.h"
#include "kernels/bsdf/fresnel.h"

namespace sheaf {

/// What smooth and rough coats share: the closure below, seen through the coat's boundary.
template <class L> struct BelowCoat {
  using F = typename L::Float;
  const CoatedParameters<L>& coat;
  F inverse_eta;

  explicit SHEAF_INLINE BelowCoat(const CoatedParameters<L>& p) : coat(p), inverse_eta(F(1.0f) / p.coat_eta) {}

  /// Bent into the coat, or with `inverse_eta` replaced by eta out of it; z is 0 where nothing gets through.
  static SHEAF_INLINE Vec3<L> bent(Vec3<L> w, F index) {
    const F x = w.x * index, y = w.y * index;
    return {x, y, safe_sqrt(F(1.0f) - fma(x, x, y * y))};
  }

  /// Both ways through the coat, for the cosines within.
  SHEAF_INLINE Spectrum<L> absorption(F cos_o, F cos_i) const {
    const F path = coat.coat_thickness * (F(1.0f) / max(cos_o, F(1e-6f)) + F(1.0f) / max(cos_i, F(1e-6f)));
    const auto& s = coat.coat_absorption;
    return {exp(-s.c0 * path), exp(-s.c1 * path), exp(-s.c2 * path), exp(-s.c3 * path)};
  }

  /// f cos and the density, without what the boundary sends back. Both directions above the surface.
  SHEAF_INLINE BsdfValue<L> evaluate(Vec3<L> wo, Vec3<L> wi) const {
    const Vec3<L> o = bent(wo, inverse_eta), i = bent(wi, inverse_eta);
    const BsdfValue<L> value = evaluate_nested<L>(coat, o, i);
    // Of solid angles, and of cosines times solid angles, outside to inside: both cosines are in f_cos.
    const F compression = sqr(inverse_eta) * wi.z / max(i.z, F(1e-6f));
    return {value.f_cos * absorption(o.z, i.z) * compression, value.pdf_solid_angle * compression};
  }

  /// A direction outside; the density is not that of the direction, but 0 where it has none.
  SHEAF_INLINE BsdfSample<L> sample(Vec3<L> wo, const Random4<L>& u) const {
    const Vec3<L> o = bent(wo, inverse_eta);
    BsdfSample<L> s = sample_nested<L>(coat, o, u);
    s.weight = s.weight * absorption(o.z, s.wi.z);
    s.wi = bent(s.wi, coat.coat_eta);
    s.valid = s.valid & (s.wi.z > F(0.0f));
    return s;
  }

  /// Probability of sampling the coat's own reflection, where it lets in `entering`.
  SHEAF_INLINE F coat_probability(Vec3<L> wo, F entering) const {
    const F cos_o = bent(wo, inverse_eta).z;
    return sheaf::coat_probability<L>(F(1.0f) - entering, coat.coat_specular, absorption(cos_o, cos_o));
  }

  /// What is left of a number that has chosen what lies below with that probability.
  static SHEAF_INLINE Random4<L> rest_of(Random4<L> u, F coat_probability) {
    u.x = clamp((u.x - coat_probability) / max(F(1.0f) - coat_probability, F(1e-20f)), F(0.0f), F(kOneMinusEpsilon));
    return u;
  }
};

template <class L> struct CoatedBsdf : CoatedParameters<L> {
  static constexpr auto kKind = ClosureKind::kCoated;
  static constexpr bool kIsSpecular = false, kIsAnisotropic = true;

  SHEAF_INLINE BsdfValue<L> evaluate(Vec3<L> wo, Vec3<L> wi) const {
    const BelowCoat<L> below(*this);
    const Float<L> entering = coat_transmittance(wo.z);
    return evaluate(below, wo, wi, entering, below.coat_probability(wo, entering));
  }

  SHEAF_INLINE BsdfSample<L> sample(Vec3<L> wo, const Random4<L>& u) const {
    using F = Float<L>;
    const BelowCoat<L> below(*this);
    const F entering = coat_transmittance(wo.z), p_coat = below.coat_probability(wo, entering);
    const auto at_coat = u.x < p_coat;
    BsdfSample<L> s = below.sample(wo, below.rest_of(u, p_coat));
    const auto is_mirror = at_coat | (s.pdf_solid_angle == F(0.0f));
    s.wi = select<L>(at_coat, {-wo.x, -wo.y, wo.z}, s.wi);
    const BsdfValue<L> value = evaluate(below, wo, s.wi, entering, p_coat);
    const Spectrum<L> nested = s.weight * (entering * coat_transmittance(s.wi.z) / max(F(1.0f) - p_coat, F(1e-20f)));
    const auto has_density = value.pdf_solid_angle > F(0.0f);
    s.weight = select<L>(at_coat, this->coat_specular * ((F(1.0f) - entering) / max(p_coat, F(1e-20f))), nested);
    s.weight =
        select<L>(is_mirror, s.weight, value.f_cos * (F(1.0f) / select(has_density, value.pdf_solid_angle, F(1.0f))));
    s.pdf_solid_angle = select(is_mirror, F(0.0f), value.pdf_solid_angle);
    s.valid = (wo.z > F(0.0f)) & (at_coat | (s.valid & (is_mirror | has_density)));
    return s;
  }

 private:
  SHEAF_INLINE Float<L> coat_transmittance(Float<L> cosine) const {
    return Float<L>(1.0f) - fresnel_dielectric<L>(abs(cosine), this->coat_eta).reflectance;
  }

  SHEAF_INLINE BsdfValue<L> evaluate(const BelowCoat<L>& below, Vec3<L> wo, Vec3<L> wi, Float<L> entering,
                                     Float<L> p_coat) const {
    using F = Float<L>;
    const BsdfValue<L> value = below.evaluate(wo, wi);
    const auto above = (wo.z > F(0.0f)) & (wi.z > F(0.0f));
    const F through = select(above, entering * coat_transmittance(wi.z), F(0.0f));
    return {value.f_cos * through, select(above, value.pdf_solid_angle * (F(1.0f) - p_coat), F(0.0f))};
  }
};

}  // namespace sheaf
