// Albedo of a surface for AOVs: the fraction of uniform illumination that it scatters towards the viewer
// (directional-hemispherical reflectance and transmittance).
#pragma once

#include "core/color/color.h"
#include "core/color/spectral_sensor.h"
#include "kernels/bsdf/list.h"

#include <array>

namespace sheaf {

/// Quadrature points in the space of a BSDF's random numbers: a Hammersley set.
inline constexpr int kAlbedoPoints = 16;
inline constexpr auto kAlbedoRule = [] {
  std::array<std::array<float, 3>, kAlbedoPoints> points{};
  const auto radical_inverse = [](int i, int base) {
    double value = 0, digit = 1;
    for (; i > 0; i /= base) value += (digit /= base) * (i % base);
    return static_cast<float>(value);
  };
  for (int i = 0; i < kAlbedoPoints; ++i)
    points[static_cast<std::size_t>(i)] = {(static_cast<float>(i) + 0.5f) / kAlbedoPoints, radical_inverse(i + 1, 2),
                                           radical_inverse(i + 1, 3)};
  return points;
}();

/// The integral of f |cos| over all directions, reflected and transmitted. Uses the same few quadrature points
/// everywhere, so it has no noise. Exact for Lambertian surfaces, mirrors and smooth glass.
template <class L, class Bsdf> [[gnu::noinline]] Spectrum<L> directional_albedo(const Bsdf& bsdf, const Vec3<L>& wo) {
  using F = Float<L>;
  Spectrum<L> sum(F(0.0f));
#pragma GCC unroll 1
  for (const std::array<float, 3>& point : kAlbedoRule) {
    const BsdfSample<L> s = bsdf.sample(wo, {F(point[0]), F(point[1]), F(point[2]), F(0.5f)});
    // Removes the factor by which refraction scales radiance, which does not change the amount of light.
    sum = sum + select<L>(s.valid, s.weight * s.eta_scale, Spectrum<L>(F(0.0f)));
  }
  return sum * F(1.0f / kAlbedoPoints);
}

/// Applies a linear map of colors to each lane.
template <class L> SHEAF_INLINE Vec3<L> map_color(Vec3f (*map)(Vec3f), const Vec3<L>& v) {
  return broadcast<L>(map({1, 0, 0})) * v.x + broadcast<L>(map({0, 1, 0})) * v.y + broadcast<L>(map({0, 0, 1})) * v.z;
}

/// Color under D65 of a reflectance at four wavelengths. Each component of XYZ is the mean of the reflectance weighted
/// by its matching function, so gray has no noise. The mean over samples has a small bias, as it is a mean of ratios.
template <class L>
SHEAF_INLINE Vec3<L> reflectance_to_rgb(const SpectralView& spectral, const Wavelengths<L>& w,
                                        const Spectrum<L>& value) {
  using F = Float<L>;
  const Spectrum<L> light = evaluate_table<L>(spectral.tables, Uint<L>(SpectrumTableView::kDaylight), w.lambda);
  Vec3<L> sum{F(0.0f), F(0.0f), F(0.0f)}, weights = sum;
  const auto add = [&](F lambda, F weight, F reflectance) SHEAF_LAMBDA_INLINE {
    const Vec3<L> xyz = map_color<L>(rec709_to_xyz, sensor_response<L>(*spectral.sensor, lambda)) * weight;
    weights = weights + xyz;
    sum = sum + xyz * reflectance;
  };
  add(w.lambda.c0, light.c0 / w.pdf.c0, value.c0);
  add(w.lambda.c1, light.c1 / w.pdf.c1, value.c1);
  add(w.lambda.c2, light.c2 / w.pdf.c2, value.c2);
  add(w.lambda.c3, light.c3 / w.pdf.c3, value.c3);
  const Vec3<L> white = broadcast<L>(rec709_to_xyz({1, 1, 1}));
  const auto mean = [](F total, F weight, F at_white)
                        SHEAF_LAMBDA_INLINE { return total / max(weight, F(1e-20f)) * at_white; };
  return map_color<L>(xyz_to_rec709, {mean(sum.x, weights.x, white.x), mean(sum.y, weights.y, white.y),
                                      mean(sum.z, weights.z, white.z)});
}

}  // namespace sheaf
