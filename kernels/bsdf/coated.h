// A smooth dielectric coat over an opaque closure (Weidlich and Wilkie, "Arbitrarily Layered Micro-Facet Surfaces",
// GRAPHITE 2007, section 4). The coat reflects light specularly, or refracts it inwards. Inside, the base scatters it,
// the coat absorbs it along both path segments (Beer-Lambert law), and it is refracted out. Internal reflection at the
// coat is lost. With o, i the directions inside the coat and R the Fresnel reflectance,
//   f = (1 - R(wo)) (1 - R(wi)) exp(-sigma_a thickness (1 / cos o + 1 / cos i)) f_nested(o, i) / eta^2.
#pragma once

#include "kernels/bsdf/coatable.h"
#include "kernels/bsdf/fresnel.h"
#include "kernels/bsdf/plastic.h"

namespace sheaf {

/// The base as seen through the boundary of the coat; shared by smooth and rough coats.
template <class L> struct BelowCoat {
  using F = typename L::Float;
  const CoatedParameters<L>& coat;
  F inverse_eta;

  explicit SHEAF_INLINE BelowCoat(const CoatedParameters<L>& p) : coat(p), inverse_eta(F(1.0f) / p.coat_eta) {}

  /// Refracts w with relative index `index`: 1 / eta into the coat, eta out of it. z is 0 at total internal reflection.
  static SHEAF_INLINE Vec3<L> bent(Vec3<L> w, F index) {
    const F x = w.x * index, y = w.y * index;
    return {x, y, safe_sqrt(F(1.0f) - fma(x, x, y * y))};
  }

  /// Transmittance along both segments inside the coat, given their cosines.
  SHEAF_INLINE Spectrum<L> absorption(F cos_o, F cos_i) const {
    const F path = coat.coat_thickness * (F(1.0f) / max(cos_o, F(1e-6f)) + F(1.0f) / max(cos_i, F(1e-6f)));
    return map_spectrum<L>(coat.coat_absorption,
                           [path](F sigma_a) SHEAF_LAMBDA_INLINE { return exp(-sigma_a * path); });
  }

  /// f cos and pdf of the base, without the losses by reflection at the boundary. Both directions are above the
  /// surface.
  BsdfValue<L> evaluate(Vec3<L> wo, Vec3<L> wi) const;

  /// Samples the base; the direction is outside the coat. `pdf_solid_angle` is that inside the coat and is used only
  /// to distinguish delta lobes (0).
  BsdfSample<L> sample(Vec3<L> wo, const Random4<L>& u) const;

  /// Probability of sampling the coat's reflection, where the coat transmits the fraction `entering`.
  SHEAF_INLINE F coat_probability(Vec3<L> wo, F entering) const {
    const F cos_o = bent(wo, inverse_eta).z;
    return sheaf::coat_probability<L>(F(1.0f) - entering, coat.coat_specular, absorption(cos_o, cos_o));
  }

  /// Rescales u.x to [0, 1) after it has chosen the base, whose probability is 1 - `coat_probability`.
  static SHEAF_INLINE Random4<L> rest_of(Random4<L> u, F coat_probability) {
    u.x = clamp((u.x - coat_probability) / max(F(1.0f) - coat_probability, F(1e-20f)), F(0.0f), F(kOneMinusEpsilon));
    return u;
  }
};

template <class L> struct CoatedBsdf : CoatedParameters<L> {
  using Closure = CoatedClosure;
  static constexpr bool kIsSpecular = false, kIsAnisotropic = true;

  BsdfValue<L> evaluate(Vec3<L> wo, Vec3<L> wi) const;

  BsdfSample<L> sample(Vec3<L> wo, const Random4<L>& u) const;

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

template <> struct BsdfOf<CoatedClosure> : BsdfTag<CoatedBsdf> {};

}  // namespace sheaf
