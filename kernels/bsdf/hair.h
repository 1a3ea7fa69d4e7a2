// Scattering by hair fibers: Chiang, Bitterli, Tappan and Burley, "A Practical and Controllable Hair and Fur Model for
// Production Path Tracing" (EGSR 2016), after d'Eon et al., "An Energy-Conserving Hair Reflectance Model" (EGSR 2011)
// and Marschner et al. 2003. In the shading frame, y runs along the fiber and z is its normal. theta is the angle to
// the plane perpendicular to the fiber; gamma is the azimuth in that plane, from the normal. Light leaves at the point
// where it enters: the fiber is thin relative to its surroundings, so both of its sides are lit through its surface.
//
//   f |cos(wi)| = sum over p < 3 of A_p(wo) M_p(theta_o, theta_i) N_p(gamma_i - gamma_o)  +  A_3 M_3 / (2 pi)
//
// where p counts path segments inside the fiber: 0 is reflection (R), 1 transmission (TT), 2 one internal reflection
// (TRT), and 3 all longer paths.
//   A  attenuation: Fresnel terms and absorption along the segments inside (d'Eon, section 5); the A_p sum to 1 without
//      absorption
//   M  longitudinal lobe of variance v around -theta_o, rotated by the tilt of the cuticle scales (d'Eon, equation 7)
//   N  azimuthal lobe around the direction of a smooth fiber: a logistic distribution trimmed to [-pi, pi] (Chiang,
//      section 4.1)
// The offset of the ray from the fiber's axis, h in [-1, 1], is the sine of gamma_o. The model is not reciprocal: A
// depends only on wo. Where light passes through a fiber, camera paths scatter at the side that faces the camera,
// photons at the side where they enter.
#pragma once

#include "core/sampling/warp.h"
#include "kernels/bsdf/bsdf.h"
#include "kernels/bsdf/fresnel.h"
#include "kernels/bsdf/microfacet.h"
#include "scene/materials/hair.h"

#include <array>

namespace sheaf {

namespace hair_detail {

/// A direction relative to the fiber.
template <class L> struct FiberAngles {
  typename L::Float sin_theta, cos_theta, gamma;

  FiberAngles() = default;
  SHEAF_INLINE explicit FiberAngles(Vec3<L> w) {
    using F = typename L::Float;
    sin_theta = w.y;
    cos_theta = sqrt(w.x * w.x + w.z * w.z);
    gamma = atan2(-w.x, select(cos_theta > F(0.0f), w.z, F(1.0f)));
  }

  /// Rotated within the plane that contains the fiber: theta plus an angle, given by its sine and cosine.
  SHEAF_INLINE FiberAngles rotated(typename L::Float sine, typename L::Float cosine) const {
    FiberAngles out = *this;
    out.sin_theta = sin_theta * cosine + cos_theta * sine;
    out.cos_theta = abs(cos_theta * cosine - sin_theta * sine);
    return out;
  }
};

/// Modified Bessel function I0(x) for x < kSmallBessel, exp(-x) I0(x) otherwise (Abramowitz and Stegun 1964, 9.8.1 and
/// 9.8.2).
inline constexpr float kSmallBessel = 3.75f;
template <class F> SHEAF_INLINE F scaled_bessel_i0(F x) {
  const F y = sqr(x * F(1 / kSmallBessel)), z = F(kSmallBessel) / max(x, F(kSmallBessel));
  const F below = polynomial(y, 1.0f, 3.5156229f, 3.0899424f, 1.2067492f, 0.2659732f, 0.0360768f, 0.0045813f);
  const F above = fma(z,
                      polynomial(z, 0.01328592f, 0.00225319f, -0.00157565f, 0.00916281f, -0.02057706f, 0.02635537f,
                                 -0.01647633f, 0.00392377f),
                      F(0.39894228f));
  return select(x < F(kSmallBessel), below, above / sqrt(max(x, F(kSmallBessel))));
}

/// M: pdf of theta_b around -theta_a, divided by cos(theta_b). Accurate for narrow lobes, too: the exponent is formed
/// from 1 - cos(theta_a + theta_b).
template <class L>
SHEAF_INLINE Float<L> longitudinal(const FiberAngles<L>& a, const FiberAngles<L>& b, Float<L> variance) {
  using F = Float<L>;
  const F away = F(0.5f) * (sqr(a.cos_theta - b.cos_theta) + sqr(a.sin_theta + b.sin_theta));
  const F x = a.cos_theta * b.cos_theta / variance;
  const F exponent = -(away / variance) - select(x < F(kSmallBessel), x, F(0.0f));
  return exp(exponent) * scaled_bessel_i0(x) / (variance * (F(1.0f) - exp(F(-2.0f) / variance)));
}

/// N: logistic distribution of scale s, trimmed to [-pi, pi].
template <class F> struct TrimmedLogistic {
  F s, tail;  ///< tail: exp(-pi / s)

  explicit SHEAF_INLINE TrimmedLogistic(F scale) : s(scale), tail(exp(F(-kPi) / scale)) {}

  /// `angle` may be any angle; it is wrapped to [-pi, pi].
  SHEAF_INLINE F density(F angle) const {
    const F revolution = angle * F(0.5f * kInvPi);
    const F x = (revolution - floor(revolution + F(0.5f))) * F(2.0f * kPi);
    const F e = exp(-(abs(x) / s));
    return e * (F(1.0f) + tail) / (s * sqr(F(1.0f) + e) * (F(1.0f) - tail));
  }

  SHEAF_INLINE F sample(F u) const {
    const F one(1.0f), smallest = tail / (one + tail), all = (one - tail) / (one + tail);
    const F below = max(fma(u, all, smallest), F(1e-30f)), above = max(fma(one - u, all, smallest), F(1e-30f));
    return clamp(s * log(below / above), F(-kPi), F(kPi));
  }
};

/// a^N, N > 0.
template <int N, class F> SHEAF_INLINE F whole_power(F a) {
  if constexpr (N == 1)
    return a;
  else if constexpr (N % 2 == 1)
    return a * whole_power<N - 1>(a);
  else
    return sqr(whole_power<N / 2>(a));
}

}  // namespace hair_detail

template <class L> struct HairBsdf : HairParameters<L> {
  using Closure = HairClosure;
  static constexpr bool kIsSpecular = false, kIsAnisotropic = true;
  using F = typename L::Float;
  using Angles = hair_detail::FiberAngles<L>;

  BsdfValue<L> evaluate(Vec3<L> wo, Vec3<L> wi) const;

  /// For a photon that passes through, evaluates at the opposite side of the fiber, so that photons and camera paths
  /// transport the same light.
  Spectrum<L> adjoint_f_cos(Vec3<L> wo, Vec3<L> wi) const;

  BsdfSample<L> sample(Vec3<L> wo, const Random4<L>& u) const;

 private:
  static constexpr std::size_t kLobes = 4;  ///< the last one is for all longer paths

  /// Everything that depends only on the outgoing direction.
  struct Lobes {
    std::array<Spectrum<L>, kLobes> attenuation;  ///< A_p
    std::array<F, kLobes> probability;            ///< of sampling each lobe; sum to 1
    std::array<F, kLobes> variance;               ///< v of M_p
    std::array<Angles, kLobes> around;            ///< theta_o rotated by the tilt of the scales
    std::array<F, kLobes - 1> middle;             ///< gamma_i for a smooth fiber
    hair_detail::TrimmedLogistic<F> azimuth;

    SHEAF_INLINE Lobes(const HairBsdf& hair, Vec3<L> wo) : azimuth(hair.azimuthal_scale()) {
      const Angles o(wo);
      const F sin_gamma_t = clamp(-wo.x / max(safe_sqrt(sqr(hair.eta) - wo.y * wo.y), F(1e-20f)), F(-1.0f), F(1.0f));
      const F cos_gamma_t = safe_sqrt(F(1.0f) - sin_gamma_t * sin_gamma_t);
      const F cos_theta_t = max(safe_sqrt(F(1.0f) - sqr(wo.y / hair.eta)), F(1e-4f));
      set_attenuation(hair, fresnel_dielectric<L>(abs(wo.z), hair.eta).reflectance,
                      hair.absorbed(F(-2.0f) * cos_gamma_t / cos_theta_t));
      const F v = hair.longitudinal_variance();
      variance = {v, F(0.25f) * v, F(4.0f) * v, F(4.0f) * v};
      const F sin1 = sin(hair.tilt), cos1 = cos(hair.tilt), sin2 = F(2.0f) * sin1 * cos1,
              cos2 = cos1 * cos1 - sin1 * sin1;
      around = {o.rotated(-sin2, cos2), o.rotated(sin1, cos1),
                o.rotated(F(2.0f) * sin2 * cos2, cos2 * cos2 - sin2 * sin2), o};
      const F through = F(2.0f) * atan2(sin_gamma_t, max(cos_gamma_t, F(1e-20f))) + F(kPi);
      middle = {-o.gamma, through - o.gamma, F(2.0f) * through - o.gamma};
    }

    /// `f`: Fresnel reflectance where light enters; `t`: transmittance of one segment inside.
    SHEAF_INLINE void set_attenuation(const HairBsdf& hair, F f, Spectrum<L> t) {
      const F one(1.0f), enters = one - f;
      const Spectrum<L> internal_reflection = t * f;
      attenuation[0] = Spectrum<L>(f);
      attenuation[1] = t * (enters * enters);
      attenuation[2] = attenuation[1] * internal_reflection;
      // The last lobe sums all longer paths, a geometric series.
      attenuation[3] = attenuation[2] * map_spectrum<L>(internal_reflection, [one](F x) SHEAF_LAMBDA_INLINE {
                         return x / max(one - x, F(1e-7f));
                       });
      const F fourth = select(hair.fourth != Uint<L>(0u), F(1.0f), F(0.0f));
      F sum(0.0f);
      for (std::size_t p = 0; p < kLobes; ++p) {
        Spectrum<L>& a = attenuation[p];
        a.c3 = a.c3 * fourth;
        probability[p] = total(a);
        sum += probability[p];
      }
      for (F& each : probability) each = each / sum;
    }
  };

  SHEAF_INLINE BsdfValue<L> evaluate(const Lobes& lobes, Vec3<L> wi) const {
    const Angles i(wi);
    BsdfValue<L> value{Spectrum<L>(F(0.0f)), F(0.0f)};
    for (std::size_t p = 0; p < kLobes; ++p) {
      const F n =
          p < kLobes - 1 ? lobes.azimuth.density(i.gamma - lobes.middle[std::min(p, kLobes - 2)]) : F(0.5f * kInvPi);
      const F density = hair_detail::longitudinal<L>(lobes.around[p], i, lobes.variance[p]) * n;
      value.f_cos = value.f_cos + lobes.attenuation[p] * density;
      value.pdf_solid_angle += lobes.probability[p] * density;
    }
    return value;
  }

  /// Transmittance of a path of length -`minus_length`, in fiber radii.
  SHEAF_INLINE Spectrum<L> absorbed(F minus_length) const {
    Spectrum<L> sigma_a = this->absorption * this->scale + this->eumelanin_absorption * this->eumelanin +
                          this->pheomelanin_absorption * this->pheomelanin;
    const Mask<L> by_color = this->by_reflectance != Uint<L>(0u);
    if (any(by_color)) sigma_a = select<L>(by_color, absorption_of_reflectance(), sigma_a);
    return map_spectrum<L>(sigma_a, [minus_length](F s) SHEAF_LAMBDA_INLINE { return exp(s * minus_length); });
  }

  /// Absorption of a fiber in hair whose multiple-scattering color is `absorption` (a fit: Chiang 2016, section 4.2).
  SHEAF_INLINE Spectrum<L> absorption_of_reflectance() const {
    const F b = this->azimuthal_roughness;
    const F fit = polynomial(b, 5.969f, -0.215f, 2.532f, -10.73f, 5.574f, 0.245f);
    return map_spectrum<L>(this->absorption,
                           [fit](F c) SHEAF_LAMBDA_INLINE { return sqr(log(clamp(c, F(1e-4f), F(1.0f))) / fit); });
  }

  /// Variance v of the first lobe and scale s of the azimuthal lobes, by fits that make roughness in [0, 1]
  /// perceptually uniform (Chiang 2016, equations 7 and 8). Roughness is at least 0.01, which single precision can
  /// still resolve.
  SHEAF_INLINE F longitudinal_variance() const {
    const F b = max(this->longitudinal_roughness, F(kMinRoughness));
    return sqr(F(0.726f) * b + F(0.812f) * b * b + F(3.7f) * hair_detail::whole_power<20>(b));
  }
  SHEAF_INLINE F azimuthal_scale() const {
    const F b = max(this->azimuthal_roughness, F(kMinRoughness));
    constexpr float kRootOfPiOver8 = 0.626657069f;
    return F(kRootOfPiOver8) * (F(0.265f) * b + F(1.194f) * b * b + F(5.372f) * hair_detail::whole_power<22>(b));
  }
  static constexpr float kMinRoughness = 0.01f;
};

template <> struct BsdfOf<HairClosure> : BsdfTag<HairBsdf> {};

}  // namespace sheaf
