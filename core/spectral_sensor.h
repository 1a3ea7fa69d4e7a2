// The sensor of spectral mode: from radiance at four wavelengths to linear Rec.709.
#pragma once

#include "core/vec.h"
#include "core/wavelengths.h"

namespace sheaf {

/// The responses of Rec.709 to light of one wavelength: matrix times CIE 1931 curves over the integral of y, per nm, on
/// the nodes of the CIE tables (every 5 nm from 360 nm), between which they are linear like those.
struct SensorCurves {
  static constexpr int kNodes = 95;
  float red[kNodes + 1], green[kNodes + 1], blue[kNodes + 1];  ///< negative where Rec.709 does not reach

  SensorCurves();
  static const SensorCurves& get();
};

/// The estimate of a pixel's colour that a path with these wavelengths makes: the mean over them of radiance * response /
/// density. Its expectation is what emission_table_to_rgb() gives for the spectrum, except that colours outside the gamut
/// keep their negative components. `radiance` is as the path carries it, hero_balance() included.
template <class L>
SHEAF_INLINE Vec3<L> radiance_to_rgb(const SensorCurves& curves, const Wavelengths<L>& w, const Spectrum<L>& radiance) {
  using F = typename L::Float;
  using U = typename L::Uint;
  Vec3<L> sum;
  const auto add = [&](F lambda, F pdf, F value) {
    const F place = clamp((lambda - F(360.0f)) * F(0.2f), F(0.0f), F(float(SensorCurves::kNodes - 1)));
    const U i = min(to_uint(place), U(std::uint32_t(SensorCurves::kNodes - 2)));
    const F t = place - to_float(i), scale = value / pdf;
    const auto response = [&](const float* curve) { return lerp(t, gather(curve, i), gather(curve, i + U(1u))); };
    sum = sum + Vec3<L>{response(curves.red), response(curves.green), response(curves.blue)} * scale;
  };
  add(w.lambda.c0, w.pdf.c0, radiance.c0);
  add(w.lambda.c1, w.pdf.c1, radiance.c1);
  add(w.lambda.c2, w.pdf.c2, radiance.c2);
  add(w.lambda.c3, w.pdf.c3, radiance.c3);
  return sum * F(0.25f);
}

}  // namespace sheaf
