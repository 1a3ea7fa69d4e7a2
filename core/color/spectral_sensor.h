// The sensor of spectral mode: from radiance at four wavelengths to linear Rec.709.
#pragma once

#include "core/color/wavelengths.h"
#include "core/math/vec.h"
#include "core/soa/lane_array.h"

namespace sheaf {

/// The responses of the Rec.709 channels to light of one wavelength, per nm: the matrix from XYZ times the CIE 1931
/// curves, over the integral of y. Tabulated at the nodes of the CIE tables (every 5 nm from 360 nm), and linear in
/// between like these.
struct SensorCurves {
  static constexpr int kNodes = 95;
  float rgb[kNodes][4];  ///< red, green, blue, padding per node; negative outside the gamut of Rec.709

  SensorCurves();
  static const SensorCurves& get();
};

/// The response at `lambda` nm, in [360, 830].
template <class L> SHEAF_INLINE Vec3<L> sensor_response(const SensorCurves& curves, typename L::Float lambda) {
  using F = typename L::Float;
  using U = typename L::Uint;
  const F position = clamp((lambda - F(360.0f)) * F(0.2f), F(0.0f), F(float(SensorCurves::kNodes - 1)));
  const U i = min(to_uint(position), U(std::uint32_t(SensorCurves::kNodes - 2)));
  const F t = position - to_float(i);
  F below[4], above[4];
  RowPointers<L> nodes(curves.rgb, i);
  nodes.read_four(below);
  nodes.read_four(above);
  return {lerp(t, below[0], above[0]), lerp(t, below[1], above[1]), lerp(t, below[2], above[2])};
}

/// The estimate of a pixel's color from one path: the mean of radiance * response / pdf over its wavelengths. The
/// expectation is that of emission_table_to_rgb() for the spectrum, except that colors outside the gamut keep their
/// negative components. `radiance`: as carried by the path; if only the first wavelength could sample the path, it
/// counts four times.
template <class L>
SHEAF_INLINE Vec3<L> radiance_to_rgb(const SensorCurves& curves, const Wavelengths<L>& w, const Spectrum<L>& radiance) {
  Vec3<L> sum;
  const auto add = [&](Float<L> lambda, Float<L> pdf, Float<L> value) {
    sum = sum + sensor_response<L>(curves, lambda) * (value / pdf);
  };
  add(w.lambda.c0, w.pdf.c0, radiance.c0);
  add(w.lambda.c1, w.pdf.c1, radiance.c1);
  add(w.lambda.c2, w.pdf.c2, radiance.c2);
  add(w.lambda.c3, w.pdf.c3, radiance.c3);
  return sum * Float<L>(0.25f);
}

}  // namespace sheaf
