// The sensor in spectral mode: the mean over all wavelengths equals the color of RGB mode.
#include "core/color/spectral_sensor.h"

#include "core/color/uplift.h"
#include "core/sampling/rng.h"
#include "scene/data/illuminants.h"
#include "scene/spectra/spectrum_set.h"
#include "tests/support/lanes_testing.h"
#include "tests/support/near.h"
#include "tests/support/spectral_testing.h"
#include "tests/support/statistics.h"

#include <doctest/doctest.h>

#include <cmath>

namespace sheaf::test_spectral_sensor {

namespace {

/// Mean and standard error per channel over independent estimates.
struct Estimate {
  double mean[3] = {}, error[3] = {};
};

/// Converts `samples` paths with radiance(wavelengths) -> Spectrum4 to RGB.
template <class F> Estimate measure(F&& radiance, int samples, std::uint32_t seed) {
  double sum[3] = {}, squares[3] = {};
  for (int i = 0; i < samples; ++i) {
    const float u = random4<Scalar>(seed, static_cast<std::uint32_t>(i), 0, 0).x;
    const Wavelengths<Scalar> w = sample_wavelengths<Scalar>(u);
    const Vec3f rgb = radiance_to_rgb<Scalar>(SensorCurves::get(), w, radiance(w));
    const double c[3] = {static_cast<double>(rgb.x), static_cast<double>(rgb.y), static_cast<double>(rgb.z)};
    for (int k = 0; k < 3; ++k) sum[k] += c[k], squares[k] += c[k] * c[k];
  }
  Estimate e;
  for (int k = 0; k < 3; ++k) {
    e.mean[k] = sum[k] / samples;
    e.error[k] = std::sqrt((squares[k] / samples - e.mean[k] * e.mean[k]) / (samples - 1));
  }
  return e;
}

constexpr int kSamples = 20000;

void check_mean(const Estimate& e, Vec3f expected, int tests) {
  const double goal[3] = {double(expected.x), double(expected.y), double(expected.z)};
  for (int k = 0; k < 3; ++k) {
    CAPTURE(k);
    CAPTURE(e.mean[k]);
    CAPTURE(goal[k]);
    CHECK(student_t_p_value((e.mean[k] - goal[k]) / e.error[k], kSamples - 1) > significance_of_each(tests));
  }
}

}  // namespace

TEST_CASE("sensor: upsampled colors under D65 are restored") {
  SpectrumSet set;
  const SpectrumRow light = set.row(SpectrumDescription::constant(1), SpectrumUse::kIlluminant);
  const Vec3f white = power_to_rgb([&](float l) { return evaluate<Scalar>(&light, 0, set.view(), Spectrum4(l)).c0; });
  const Vec3f colors[] = {
      {1, 1, 1}, {0.8f, 0.1f, 0.2f}, {0.1f, 0.6f, 0.15f}, {0.02f, 0.05f, 0.7f}, {0.9f, 0.8f, 0.05f}};
  std::uint32_t seed = 40;
  for (const Vec3f rgb : colors) {
    const SpectrumRow row = set.row(SpectrumDescription::rgb(rgb.x, rgb.y, rgb.z), SpectrumUse::kReflectance);
    const auto e = measure(
        [&](const Wavelengths<Scalar>& w) {
          return evaluate<Scalar>(&light, 0, set.view(), w.lambda) * evaluate<Scalar>(&row, 0, set.view(), w.lambda);
        },
        kSamples, ++seed);
    check_mean(e, rgb * white, 15);
  }
  // The tabulated D65 and the white of the matrix differ in the fourth decimal.
  CHECK(largest_difference(white, {1, 1, 1}) < 1e-3f);
}

TEST_CASE("sensor: tabulated emission has its color in RGB mode") {
  SpectrumSet set;
  const std::vector<float> wavelengths{380, 450, 560, 640, 780}, values{1, 4, 3, 6, 1};
  const SpectrumRow row = set.row({SpectrumDescription::Table{wavelengths, values}}, SpectrumUse::kIlluminant);
  check_mean(measure([&](const Wavelengths<Scalar>& w) { return evaluate<Scalar>(&row, 0, set.view(), w.lambda); },
                     kSamples, 7),
             emission_table_to_rgb(wavelengths, values), 3);
}

TEST_CASE("sensor: white stays white under D65 and under equal energy") {
  SpectrumSet set;
  for (const auto& [name, x, y] : {std::tuple{"d65", 0.3127, 0.3290}, {"e", 1.0 / 3, 1.0 / 3}}) {
    const SpectrumRow row = set.row({find_illuminant(name).value()}, SpectrumUse::kIlluminant);
    double sum[3] = {};
    constexpr int kSteps = 4096;  // evenly spaced, which gives the mean without noise
    for (int i = 0; i < kSteps; ++i) {
      const auto w = sample_wavelengths<Scalar>((static_cast<float>(i) + 0.5f) / kSteps);
      const Spectrum4 radiance = evaluate<Scalar>(&row, 0, set.view(), w.lambda);
      const Vec3f xyz = rec709_to_xyz(radiance_to_rgb<Scalar>(SensorCurves::get(), w, radiance));
      const double c[3] = {static_cast<double>(xyz.x), static_cast<double>(xyz.y), static_cast<double>(xyz.z)};
      for (int k = 0; k < 3; ++k) sum[k] += c[k] / kSteps;
    }
    const double total = sum[0] + sum[1] + sum[2];
    CHECK(std::abs(sum[0] / total - x) < 0.002);
    CHECK(std::abs(sum[1] / total - y) < 0.002);
    CHECK(sum[1] == near(1, 1e-3));
  }
}

TEST_CASE("sensor: paths that only the hero wavelength can generate count four times") {
  // Each wavelength reaches the light on a different path, as behind a prism, so that only the first one contributes.
  const auto e = measure([](const Wavelengths<Scalar>&) { return Spectrum4(4, 0, 0, 0); }, kSamples, 9);
  check_mean(e, power_to_rgb([](float) { return 1.0f; }), 3);
}

TEST_CASE("sensor: SIMD results equal scalar ones") {
  const WideFloat u = wide_floats([](int lane) { return (static_cast<float>(lane) + 0.3f) / kWidth; });
  const auto wide = sample_wavelengths<Wide>(u);
  const Spectrum<Wide> radiance(WideFloat(1), WideFloat(2), WideFloat(0), WideFloat(5));
  const Vec3<Wide> rgb = radiance_to_rgb<Wide>(SensorCurves::get(), wide, radiance);
  for (int lane = 0; lane < kWidth; ++lane) {
    const auto w = sample_wavelengths<Scalar>(u[lane]);
    const Vec3f one = radiance_to_rgb<Scalar>(SensorCurves::get(), w, Spectrum4(1, 2, 0, 5));
    CHECK(difference(rgb.x[lane], one.x) < 1e-5);
    CHECK(difference(rgb.y[lane], one.y) < 1e-5);
    CHECK(difference(rgb.z[lane], one.z) < 1e-5);
  }
}

}  // namespace sheaf::test_spectral_sensor
