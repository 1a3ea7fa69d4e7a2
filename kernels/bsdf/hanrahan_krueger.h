// Single scattering in a slab of a medium (Hanrahan and Krueger, "Reflection from Layered Surfaces due to Subsurface
// Scattering", SIGGRAPH 1993, section 5.1), without its boundaries: a coat provides refraction and the terms T of the
// paper. With albedo W, phase function p, optical thickness t and cosines o and i,
//   f cos = W p i / (i + o) (1 - exp(-t (1 / i + 1 / o)))         for reflection,
//   f cos = W p i / (i - o) (exp(-t / i) - exp(-t / o))           for transmission.
// The fraction exp(-t / o) passes unscattered. Multiple scattering is lost.
#pragma once

#include "core/math/frame.h"
#include "kernels/bsdf/bsdf.h"
#include "kernels/phase/henyey_greenstein.h"
#include "scene/materials/hanrahan_krueger.h"

namespace sheaf {

template <class L> struct HanrahanKruegerBsdf : HanrahanKruegerParameters<L> {
  using Closure = HanrahanKruegerClosure;
  static constexpr bool kIsSpecular = false, kIsAnisotropic = false;

  SHEAF_INLINE BsdfValue<L> evaluate(Vec3<L> wo, Vec3<L> wi) const {
    using F = Float<L>;
    const F phase = this->phase().evaluate(wo, Frame<L>::from_normal(wo).to_local(wi)).pdf_solid_angle;
    return {scattered(wo, wi) * phase, phase * (F(1.0f) - passing_probability(wo))};
  }

  SHEAF_INLINE BsdfSample<L> sample(Vec3<L> wo, const Random4<L>& u) const {
    using F = Float<L>;
    const F pass = passing_probability(wo), stay = F(1.0f) - pass;
    const auto passes = u.x < pass;
    const BsdfSample<L> deflected = phase().sample(wo, u);
    BsdfSample<L> s;
    s.wi = select<L>(passes, -wo, Frame<L>::from_normal(wo).to_world(deflected.wi));
    const F inverse_o = F(1.0f) / max(abs(wo.z), F(1e-6f));
    s.weight =
        select<L>(passes, attenuation(depth(), inverse_o) * (F(1.0f) / pass), scattered(wo, s.wi) * (F(1.0f) / stay));
    s.pdf_solid_angle = select(passes, F(0.0f), deflected.pdf_solid_angle * stay);
    s.eta_scale = F(1.0f);
    s.valid = passes | deflected.valid;
    return s;
  }

 private:
  SHEAF_INLINE HenyeyGreensteinBsdf<L> phase() const {
    HenyeyGreensteinBsdf<L> hg;
    hg.g = this->g;
    return hg;
  }
  SHEAF_INLINE Mask<L> is_by_albedo() const { return this->by_albedo != Uint<L>(0u); }
  SHEAF_INLINE Spectrum<L> extinction() const {
    return select<L>(is_by_albedo(), this->first, this->first + this->second);
  }
  /// Optical thickness along the normal.
  SHEAF_INLINE Spectrum<L> depth() const { return extinction() * this->thickness; }

  static SHEAF_INLINE Spectrum<L> attenuation(Spectrum<L> t, Float<L> path) {
    return map_spectrum<L>(t, [path](Float<L> x) SHEAF_LAMBDA_INLINE { return exp(-x * path); });
  }

  /// Probability that sample() lets light pass unscattered. It averages three lanes, because the fourth may not be a
  /// color; clamping keeps both choices possible.
  SHEAF_INLINE Float<L> passing_probability(Vec3<L> wo) const {
    using F = Float<L>;
    const Spectrum<L> a = attenuation(depth(), F(1.0f) / max(abs(wo.z), F(1e-6f)));
    return clamp((a.c0 + a.c1 + a.c2) * F(1.0f / 3.0f), F(0.01f), F(0.99f));
  }

  /// f cos divided by the phase function.
  SHEAF_INLINE Spectrum<L> scattered(Vec3<L> wo, Vec3<L> wi) const {
    using F = Float<L>;
    const F o = max(abs(wo.z), F(1e-6f)), i = max(abs(wi.z), F(1e-6f)), inverse_o = F(1.0f) / o;
    const F inverse_i = F(1.0f) / i;
    const auto back = wo.z * wi.z > F(0.0f);
    // In both cases the result is the mean of the transmittance over the depth of the vertex, where the path length
    // grows from `min_inverse` by `more`, in units of the thickness.
    const F min_inverse = select(back, F(0.0f), min(inverse_o, inverse_i));
    const F more = select(back, inverse_o + inverse_i, abs(inverse_i - inverse_o));
    const Spectrum<L> sigma_s = select<L>(is_by_albedo(), this->first * this->second, this->first);
    const Spectrum<L> t = depth();
    const auto one = [&](F s, F d) SHEAF_LAMBDA_INLINE {
      const F x = d * more;
      const F mean = select(x < F(0.02f), fma(x, fma(x, F(1.0f / 6.0f), F(-0.5f)), F(1.0f)),
                            (F(1.0f) - exp(-x)) / max(x, F(0.02f)));
      return s * this->thickness * inverse_o * exp(-d * min_inverse) * mean;
    };
    return {one(sigma_s.c0, t.c0), one(sigma_s.c1, t.c1), one(sigma_s.c2, t.c2), one(sigma_s.c3, t.c3)};
  }
};

template <> struct BsdfOf<HanrahanKruegerClosure> : BsdfTag<HanrahanKruegerBsdf> {};

}  // namespace sheaf
