// Rayleigh's phase function, for particles far smaller than the wavelength: p(c) = 3 / (16 pi) (1 + c^2), where c is
// the cosine of the deflection angle (Chandrasekhar, "Radiative Transfer", 1960, section 1.2).
//
// The CDF is a cubic polynomial: c^3 + 3 c = 2 q with q = 4 u - 2. Its only real root is A - 1 / A with A^3 = q +
// sqrt(1 + q^2) (Cardano). By symmetry it is enough to solve for q >= 0, where nothing cancels.
#pragma once

#include "core/sampling/warp.h"
#include "kernels/phase/phase_function.h"
#include "scene/materials/phase_functions.h"

namespace sheaf {

template <class L> struct RayleighBsdf : RayleighParameters<L> {
  using Closure = RayleighClosure;
  static constexpr bool kIsSpecular = false, kIsAnisotropic = false;

  SHEAF_INLINE BsdfValue<L> evaluate(Vec3<L>, Vec3<L> wi) const {
    const Float<L> pdf = density(wi.z);
    return {Spectrum<L>(pdf), pdf};
  }

  SHEAF_INLINE BsdfSample<L> sample(Vec3<L>, const Random4<L>& u) const {
    using F = Float<L>;
    const F signed_q = fma(F(4.0f), u.y, F(-2.0f)), q = abs(signed_q);
    const F a = pow(q + sqrt(fma(q, q, F(1.0f))), F(1.0f / 3.0f));
    const F cosine = copysign(clamp(a - F(1.0f) / a, F(0.0f), F(1.0f)), signed_q);
    const F sine = safe_sqrt(F(1.0f) - cosine * cosine);
    const auto azimuth = sincos_2pi<L>(u.z);
    BsdfSample<L> s;
    s.wi = {sine * azimuth.cos, sine * azimuth.sin, -cosine};
    s.weight = Spectrum<L>(F(1.0f));
    s.pdf_solid_angle = density(cosine);
    s.eta_scale = F(1.0f);
    s.valid = s.pdf_solid_angle > F(0.0f);
    return s;
  }

 private:
  /// Symmetric in c.
  static SHEAF_INLINE Float<L> density(Float<L> c) {
    return Float<L>(3.0f / 16.0f * kInvPi) * fma(c, c, Float<L>(1.0f));
  }
};

template <> struct BsdfOf<RayleighClosure> : BsdfTag<RayleighBsdf> {};

}  // namespace sheaf
