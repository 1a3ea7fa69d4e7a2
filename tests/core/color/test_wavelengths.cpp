// Hero wavelength sampling: the pdf, the rotation of the wavelengths, and the balance heuristic over them.
#include "core/color/wavelengths.h"

#include "core/color/color.h"
#include "tests/support/chi_square.h"
#include "tests/support/lanes_testing.h"
#include "tests/support/spectral_testing.h"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <vector>

namespace sheaf::test_wavelengths {

namespace {

constexpr int kBins = 94;
constexpr double kBinWidth = 5.0;

std::array<float, 4> values(const Spectrum4& s) { return {s.c0, s.c1, s.c2, s.c3}; }

/// The sensor's response to light of one wavelength.
Vec3f response(double lambda) { return xyz_to_rec709(cie_1931_xyz(static_cast<float>(lambda))); }

/// The cumulative distribution function at `lambda`, from the quantiles.
double cumulative(double lambda) {
  constexpr int kCells = WavelengthQuantiles::kCells;
  for (int i = 0; i < 4 * kCells; ++i) {
    const double a = static_cast<double>(kWavelengthQuantiles.nodes[i % kCells][i / kCells]);
    const double b = static_cast<double>(kWavelengthQuantiles.nodes[i % kCells + 1][i / kCells]);
    if (lambda <= b) return (i + std::max(0.0, (lambda - a) / (b - a))) / (4 * kCells);
  }
  return 1;
}

}  // namespace

TEST_CASE("wavelengths: each of the four follows the pdf") {
  constexpr int kSamples = 200000;
  std::vector<double> observed[4], expected(kBins);
  for (auto& counts : observed) counts.resize(kBins);
  for (int i = 0; i < kSamples; ++i) {
    const float u = random4<Scalar>(11, static_cast<std::uint32_t>(i), 0, 0).x;
    const auto lambda = values(sample_wavelengths<Scalar>(u).lambda);
    for (std::size_t k = 0; k < 4; ++k) {
      const int bin = static_cast<int>((static_cast<double>(lambda[k]) - 360.0) / kBinWidth);
      ++observed[k][static_cast<std::size_t>(std::clamp(bin, 0, kBins - 1))];
    }
  }
  for (int bin = 0; bin < kBins; ++bin) {
    const double a = 360.0 + kBinWidth * bin;
    expected[static_cast<std::size_t>(bin)] = (cumulative(a + kBinWidth) - cumulative(a)) * kSamples;
  }
  for (const auto& counts : observed) CHECK(chi_square(counts, expected).p_value > significance_of_each(4));
}

TEST_CASE("wavelengths: quantiles increase from one end of the range to the other") {
  constexpr int kCells = WavelengthQuantiles::kCells;
  CHECK(kWavelengthQuantiles.nodes[0][0] == 360.0f);
  CHECK(kWavelengthQuantiles.nodes[kCells][3] == 830.0f);
  for (int k = 0; k < 4; ++k) {
    if (k > 0) CHECK(kWavelengthQuantiles.nodes[0][k] == kWavelengthQuantiles.nodes[kCells][k - 1]);
    for (int i = 0; i < kCells; ++i) CHECK(kWavelengthQuantiles.nodes[i][k] < kWavelengthQuantiles.nodes[i + 1][k]);
  }
}

TEST_CASE("wavelengths: range and pdf and rotation are right for every random number") {
  for (int i = 0; i <= 4096; ++i) {
    const float u = std::min(static_cast<float>(i) / 4096.0f, 0.99999994f);
    CAPTURE(u);
    const Wavelengths<Scalar> w = sample_wavelengths<Scalar>(u);
    const auto lambda = values(w.lambda), pdf = values(w.pdf);
    for (std::size_t k = 0; k < 4; ++k) {
      CHECK(lambda[k] >= 360.0f);
      CHECK(lambda[k] <= 830.0f);
      // The pdf is the slope of the CDF, a step function.
      const double at = static_cast<double>(lambda[k]), below = std::max(360.0, at - 1e-3),
                   above = std::min(830.0, at + 1e-3);
      const double slopes[2] = {(cumulative(at) - cumulative(below)) / std::max(at - below, 1e-9),
                                (cumulative(above) - cumulative(at)) / std::max(above - at, 1e-9)};
      const double p = static_cast<double>(pdf[k]);
      CHECK((std::abs(slopes[0] / p - 1) < 1e-3 || std::abs(slopes[1] / p - 1) < 1e-3));
      // The CDF maps each wavelength back to its random number.
      const double rotated = std::fmod(static_cast<double>(u) + 0.25 * static_cast<double>(k), 1.0);
      CHECK(std::abs(cumulative(static_cast<double>(lambda[k])) - rotated) < 2e-6);
    }
  }
}

TEST_CASE("wavelengths: SIMD results equal scalar ones") {
  const WideFloat u = wide_floats([](int lane) { return (static_cast<float>(lane) + 0.5f) / kWidth; });
  const Wavelengths<Wide> wide = sample_wavelengths<Wide>(u);
  for (int lane = 0; lane < kWidth; ++lane) {
    const Wavelengths<Scalar> one = sample_wavelengths<Scalar>(u[lane]);
    CHECK(difference(wide.lambda.c0[lane], one.lambda.c0) < 1e-6);
    CHECK(difference(wide.lambda.c3[lane], one.lambda.c3) < 1e-6);
    CHECK(difference(wide.pdf.c1[lane], one.pdf.c1) < 1e-6);
    CHECK(difference(wide.pdf.c2[lane], one.pdf.c2) < 1e-6);
  }
}

TEST_CASE("wavelengths: white light is estimated with little variance") {
  // The sum over red, green and blue of variance over squared mean, in daylight and in equal-energy light.
  for (const bool in_daylight : {true, false}) {
    double mean[3] = {}, squares[3] = {}, alone[3] = {};
    constexpr int kSteps = 8192;
    for (int i = 0; i < kSteps; ++i) {
      const auto w = sample_wavelengths<Scalar>((static_cast<float>(i) + 0.5f) / kSteps);
      const auto lambda = values(w.lambda), pdf = values(w.pdf);
      double sum[3] = {};
      for (std::size_t k = 0; k < 4; ++k) {
        const Vec3f rgb = response(static_cast<double>(lambda[k])) * ((in_daylight ? cie_d65(lambda[k]) : 1) / pdf[k]);
        const double each[3] = {static_cast<double>(rgb.x), static_cast<double>(rgb.y), static_cast<double>(rgb.z)};
        for (int c = 0; c < 3; ++c) sum[c] += each[c] / 4, alone[c] += each[c] * each[c] / (4 * kSteps);
      }
      for (int c = 0; c < 3; ++c) mean[c] += sum[c] / kSteps, squares[c] += sum[c] * sum[c] / kSteps;
    }
    double of_four = 0, of_one = 0;
    for (int c = 0; c < 3; ++c) {
      of_four += squares[c] / (mean[c] * mean[c]) - 1;
      of_one += alone[c] / (mean[c] * mean[c]) - 1;
    }
    CAPTURE(in_daylight);
    CHECK(of_four < 0.008);
    CHECK(of_one < 13);
  }
}

}  // namespace sheaf::test_wavelengths
