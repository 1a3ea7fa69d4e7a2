// Hero wavelengths: the four wavelengths that a path carries in spectral mode, all made from one uniform number.
#pragma once

#include "core/spectrum.h"

namespace sheaf {

/// Four wavelengths and the density of each, which is the same function of wavelength for all four.
template <class L> struct Wavelengths {
  Spectrum<L> lambda;  ///< nm, in [360, 830]
  Spectrum<L> pdf;     ///< per nm; positive
  static constexpr auto fields(auto& s) { return std::tie(s.lambda, s.pdf); }
};

namespace detail {
/// Density proportional to 1 / cosh^2(rate (lambda - centre)), a shape that follows the observer's sensitivity and
/// can be inverted: Radziszewski, Boryczko and Alda, "An Improved Technique for Full Spectral Rendering" (2009),
/// with the rate of Pharr, Jakob and Humphreys, "Physically Based Rendering" (4th ed., section 4.5.4). Their centre
/// is 538 nm; 520 nm does as well for single wavelengths, and leaves white under D65 with less noise when four are
/// used: the standard deviations per path of red, green and blue are 25, 1 and 42 % instead of 15, 3 and 58 %.
inline constexpr float kWavelengthCentre = 520.0f, kWavelengthRate = 0.0072f;
/// tanh(rate (lambda - centre)) at 360 and at 830 nm.
inline constexpr float kTanhMin = -0.81841555f, kTanhMax = 0.97722981f;

template <class L>
SHEAF_INLINE void invert_wavelength(typename L::Float u, typename L::Float& lambda, typename L::Float& pdf) {
  using F = typename L::Float;
  const F t = fma(u, F(kTanhMax - kTanhMin), F(kTanhMin));
  const F x = F(0.5f) * log((F(1.0f) + t) / (F(1.0f) - t));
  lambda = clamp(fma(x, F(1.0f / kWavelengthRate), F(kWavelengthCentre)), F(360.0f), F(830.0f));
  // 1 / cosh^2 = 1 - tanh^2.
  pdf = (F(1.0f) - t * t) * F(kWavelengthRate / (kTanhMax - kTanhMin));
}
}  // namespace detail

/// The wavelengths that belong to `u` in [0, 1). The first inverts the density's cumulative function at u, the others
/// at u + k/4 modulo 1: each alone has the density, together they are spread over the whole range (Wilkie et al.,
/// "Hero Wavelength Spectral Sampling", EGSR 2014, with the rotation before the inversion instead of after it). A
/// path stores u alone and calls this wherever it needs the wavelengths.
template <class L> SHEAF_INLINE Wavelengths<L> sample_wavelengths(typename L::Float u) {
  using F = typename L::Float;
  Wavelengths<L> w;
  const auto rotate = [&](float by) {
    const F turned = u + F(by);
    return select(turned >= F(1.0f), turned - F(1.0f), turned);
  };
  detail::invert_wavelength<L>(u, w.lambda.c0, w.pdf.c0);
  detail::invert_wavelength<L>(rotate(0.25f), w.lambda.c1, w.pdf.c1);
  detail::invert_wavelength<L>(rotate(0.5f), w.lambda.c2, w.pdf.c2);
  detail::invert_wavelength<L>(rotate(0.75f), w.lambda.c3, w.pdf.c3);
  return w;
}

/// The density per nm with which any one of the four is `lambda`, in nm; zero outside [360, 830].
template <class L> SHEAF_INLINE Float<L> wavelength_pdf(typename L::Float lambda) {
  using F = typename L::Float;
  const F e = exp(abs(lambda - F(detail::kWavelengthCentre)) * F(-2.0f * detail::kWavelengthRate));
  const F one = F(1.0f);
  const F sech2 = F(4.0f) * e / sqr(one + e);
  const auto inside = (lambda >= F(360.0f)) & (lambda <= F(830.0f));
  return select(inside, sech2 * F(detail::kWavelengthRate / (detail::kTanhMax - detail::kTanhMin)), F(0.0f));
}

/// What a path's throughput is to be multiplied by when light is found: the balance heuristic over the four wavelengths
/// as strategies (Wilkie et al. 2014). `relative` holds, for each wavelength, the density with which it would have made
/// the path, over the density by which the throughput was divided (that of the first). One everywhere gives 1; where
/// only the first could have made the path (refraction by a dispersing surface: 1, 0, 0, 0) it gives 4.
template <class L> SHEAF_INLINE Float<L> hero_balance(Spectrum<L> relative) {
  return Float<L>(4.0f) / ((relative.c0 + relative.c1) + (relative.c2 + relative.c3));
}

}  // namespace sheaf
