// Integrals over wavelength for comparison with the spectral code, computed independently of it.
#pragma once

#include "core/color/color.h"

#include <array>

namespace sheaf {

/// Calls f(wavelength in nm, weight in nm) for the nodes of Simpson's rule in intervals of 1 nm over the range of the
/// CIE tables. All kinks of the tables are interval ends.
template <class F> void for_each_wavelength(F&& f) {
  constexpr int kIntervals = 940;
  for (int i = 0; i <= kIntervals; ++i) {
    const double weight = (i == 0 || i == kIntervals ? 1.0 : i % 2 == 1 ? 4.0 : 2.0) * 0.5 / 3.0;
    f(360.0 + 0.5 * i, weight);
  }
}

/// XYZ of a spectral power distribution, power(wavelength), scaled so that a constant 1 has Y = 1.
template <class F> std::array<double, 3> power_to_xyz(F&& power) {
  std::array<double, 3> sum{};
  double y = 0;
  for_each_wavelength([&](double wavelength, double weight) {
    const Vec3f curves = cie_1931_xyz(static_cast<float>(wavelength));
    const double p = weight * static_cast<double>(power(static_cast<float>(wavelength)));
    sum[0] += p * static_cast<double>(curves.x);
    sum[1] += p * static_cast<double>(curves.y);
    sum[2] += p * static_cast<double>(curves.z);
    y += weight * static_cast<double>(curves.y);
  });
  return {sum[0] / y, sum[1] / y, sum[2] / y};
}

/// Linear Rec.709 of a spectral power distribution, see power_to_xyz().
template <class F> Vec3f power_to_rgb(F&& power) {
  const auto [x, y, z] = power_to_xyz(power);
  return xyz_to_rec709({static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)});
}

/// Rec.709 color of a reflectance under D65; white is (1, 1, 1).
template <class F> Vec3f reflectance_to_rgb(F&& reflectance) {
  static const Vec3f white = power_to_rgb([](float wavelength) { return cie_d65(wavelength); });
  const Vec3f rgb = power_to_rgb([&](float wavelength) { return reflectance(wavelength) * cie_d65(wavelength); });
  return {rgb.x / white.x, rgb.y / white.y, rgb.z / white.z};
}

inline float largest_difference(Vec3f a, Vec3f b) { return max_component(abs(a - b)); }

}  // namespace sheaf
