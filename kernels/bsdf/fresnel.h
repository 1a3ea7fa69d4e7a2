// Fresnel reflectance of smooth boundaries for unpolarized light.
#pragma once

#include "core/color/spectrum.h"

namespace sheaf {

/// Reflection and refraction at a dielectric boundary.
template <class L> struct DielectricFresnel {
  typename L::Float reflectance;      ///< in [0, 1]; 1 at total internal reflection
  typename L::Float cos_transmitted;  ///< of the refracted direction; sign opposite to cos_incident
  typename L::Float eta;              ///< index of refraction, far side over near side
};

/// `cos_incident`: cosine to the normal, positive outside. `eta`: index of the inside over that of the outside (Pharr
/// et al. 2023, section 9.3.5).
template <class L> SHEAF_INLINE DielectricFresnel<L> fresnel_dielectric(Float<L> cos_incident, Float<L> eta) {
  using F = Float<L>;
  const auto outside = cos_incident >= F(0.0f);
  const F relative = select(outside, eta, F(1.0f) / eta);
  const F cos_i = abs(cos_incident);
  const F cos_t2 = F(1.0f) - (F(1.0f) - cos_i * cos_i) / (relative * relative);
  const F cos_t = safe_sqrt(cos_t2);
  const F parallel = (relative * cos_i - cos_t) / (relative * cos_i + cos_t);
  const F perpendicular = (cos_i - relative * cos_t) / (cos_i + relative * cos_t);
  const F r = F(0.5f) * (parallel * parallel + perpendicular * perpendicular);
  // Equal indices at grazing incidence would be 0 / 0; a matched boundary reflects nothing.
  const F matched = select(relative == F(1.0f), F(0.0f), r);
  return {select(cos_t2 <= F(0.0f), F(1.0f), matched), select(outside, -cos_t, cos_t), relative};
}

/// Reflectance at normal incidence of a dielectric whose relative index of refraction is `eta`.
template <class F> SHEAF_INLINE F normal_reflectance(F eta) { return sqr((eta - F(1.0f)) / (eta + F(1.0f))); }

/// Reflectance of a conductor with complex index eta + i k relative to the outside, for one wavelength. `cos_incident`
/// is in [0, 1] (Pharr et al. 2023, equation 9.5, with the complex square root written out).
template <class F> SHEAF_INLINE F fresnel_conductor(F cos_incident, F eta, F k) {
  const F cos2 = cos_incident * cos_incident, sin2 = F(1.0f) - cos2;
  const F eta2 = eta * eta, k2 = k * k;
  const F t0 = eta2 - k2 - sin2;
  const F a2_plus_b2 = safe_sqrt(t0 * t0 + F(4.0f) * eta2 * k2);
  const F a = safe_sqrt(F(0.5f) * (a2_plus_b2 + t0));
  const F t1 = a2_plus_b2 + cos2, t2 = F(2.0f) * a * cos_incident;
  const F t3 = cos2 * a2_plus_b2 + sin2 * sin2, t4 = t2 * sin2;
  // (s + p) / 2, where s = (t1 - t2) / (t1 + t2) is the perpendicular part and p = s (t3 - t4) / (t3 + t4) the parallel
  // part. The lower bound avoids 0 / 0 for eta = k = 0 at normal incidence.
  return (t1 - t2) * t3 / max((t1 + t2) * (t3 + t4), F(1e-30f));
}
/// The same for four wavelengths.
template <class L>
SHEAF_INLINE Spectrum<L> fresnel_conductor(Float<L> cos_incident, const Spectrum<L>& eta, const Spectrum<L>& k) {
  return {fresnel_conductor(cos_incident, eta.c0, k.c0), fresnel_conductor(cos_incident, eta.c1, k.c1),
          fresnel_conductor(cos_incident, eta.c2, k.c2), fresnel_conductor(cos_incident, eta.c3, k.c3)};
}

}  // namespace sheaf
