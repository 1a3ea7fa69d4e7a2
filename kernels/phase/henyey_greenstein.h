// The phase function of Henyey and Greenstein ("Diffuse Radiation in the Galaxy", Astrophysical Journal 93, 1941):
//   p(c) = (1 - g^2) / (4 pi (1 + g^2 - 2 g c)^(3/2)),  c: cosine of the deflection angle.
//
// In strongly forward- or backward-scattering media, the peak is narrower than floats near 1 can resolve. Cosines t to
// the peak direction are therefore represented by m = 1 - t: the base of the power in p is (1 - |g|)^2 + 2 |g| m.
// Inverting the CDF of m, without the division by g of the usual form, gives
//   m = (1 - |g|)^2 v (1 + |g| + w) / w^2,  w = 1 + |g| - 2 |g| v,  v uniform in [0, 1],
// which is 2 v for g = 0.
#pragma once

#include "core/sampling/warp.h"
#include "kernels/phase/phase_function.h"
#include "scene/materials/phase_functions.h"

namespace sheaf {

template <class L> struct HenyeyGreensteinBsdf : HenyeyGreensteinParameters<L> {
  using Closure = HenyeyGreensteinClosure;
  static constexpr bool kIsSpecular = false, kIsAnisotropic = false;

  SHEAF_INLINE BsdfValue<L> evaluate(Vec3<L>, Vec3<L> wi) const {
    using F = Float<L>;
    const F a = abs(this->g), rest = F(1.0f) - a;
    const F t = copysign(F(1.0f), this->g) * -wi.z;
    const auto ahead = t > F(0.0f);
    const F m = select(ahead, fma(wi.x, wi.x, wi.y * wi.y), F(1.0f) - t) / select(ahead, F(1.0f) + t, F(1.0f));
    const F squared = fma(a + a, m, rest * rest);
    const F pdf = F(0.25f * kInvPi) * rest * (F(1.0f) + a) / (squared * sqrt(squared));
    return {Spectrum<L>(pdf), pdf};
  }

  SHEAF_INLINE BsdfSample<L> sample(Vec3<L>, const Random4<L>& u) const {
    using F = Float<L>;
    const F a = abs(this->g), rest = F(1.0f) - a;
    const F w = fma(F(-2.0f) * a, u.y, F(1.0f) + a), inverse_w = F(1.0f) / w;
    const F narrow = rest * inverse_w;
    const F m = min(narrow * narrow * u.y * (F(1.0f) + a + w), F(2.0f));
    const F sine = sqrt(m * (F(2.0f) - m));
    const auto azimuth = sincos_2pi<L>(u.z);
    const F root = narrow * (F(1.0f) + a);  // of `squared` in evaluate()
    BsdfSample<L> s;
    s.wi = {sine * azimuth.cos, sine * azimuth.sin, copysign(F(1.0f), this->g) * (m - F(1.0f))};
    s.weight = Spectrum<L>(F(1.0f));
    s.pdf_solid_angle = F(0.25f * kInvPi) * rest * (F(1.0f) + a) / (root * root * root);
    s.eta_scale = F(1.0f);
    s.valid = s.pdf_solid_angle > F(0.0f);
    return s;
  }
};

template <> struct BsdfOf<HenyeyGreensteinClosure> : BsdfTag<HenyeyGreensteinBsdf> {};

}  // namespace sheaf
