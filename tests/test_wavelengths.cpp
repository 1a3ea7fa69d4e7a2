// Hero wavelengths: their density, their rotation, and the balance over them.
#include "core/wavelengths.h"

#include "core/color.h"
#include "tests/chi_square.h"
#include "tests/lanes_testing.h"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <utility>
#include <vector>

using namespace sheaf;

namespace {

constexpr int kBins = 94;
constexpr double kBinWidth = 5.0;

std::array<float, 4> values(const Spectrum4& s) { return {s.c0, s.c1, s.c2, s.c3}; }

/// The probability of [a, b] in closed form.
double probability(double a, double b) {
  const auto integral = [](double lambda) { return std::tanh(0.0072 * (lambda - 520.0)); };
  return (integral(b) - integral(a)) / (integral(830) - integral(360));
}

}  // namespace

TEST_CASE("wavelengths: each of the four is distributed as the density says") {
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
  double total = 0;
  for (int bin = 0; bin < kBins; ++bin) {
    const double a = 360.0 + kBinWidth * bin;
    double mass = 0;  // Simpson's rule
    for (const auto& [at, weight] : {std::pair{a, 1.0}, {a + kBinWidth / 2, 4.0}, {a + kBinWidth, 1.0}})
      mass += weight * kBinWidth / 6 * static_cast<double>(wavelength_pdf<Scalar>(static_cast<float>(at)));
    CHECK(mass == doctest::Approx(probability(a, a + kBinWidth)).epsilon(1e-4));
    total += mass;
    expected[static_cast<std::size_t>(bin)] = mass * kSamples;
  }
  CHECK(total == doctest::Approx(1).epsilon(1e-5));
  for (const auto& counts : observed) CHECK(chi_square(counts, expected).p_value > significance_of_each(4));
}

TEST_CASE("wavelengths: range, density and rotation for every number") {
  for (int i = 0; i <= 4096; ++i) {
    const float u = std::min(static_cast<float>(i) / 4096.0f, 0.99999994f);
    CAPTURE(u);
    const Wavelengths<Scalar> w = sample_wavelengths<Scalar>(u);
    const auto lambda = values(w.lambda), pdf = values(w.pdf);
    for (std::size_t k = 0; k < 4; ++k) {
      CHECK(lambda[k] >= 360.0f);
      CHECK(lambda[k] <= 830.0f);
      CHECK(pdf[k] == doctest::Approx(static_cast<double>(wavelength_pdf<Scalar>(lambda[k]))).epsilon(1e-4));
      // The cumulative function takes each back to its number.
      const double turned = std::fmod(static_cast<double>(u) + 0.25 * static_cast<double>(k), 1.0);
      CHECK(std::abs(probability(360, static_cast<double>(lambda[k])) - turned) < 2e-6);
    }
  }
  CHECK(wavelength_pdf<Scalar>(359.9f) == 0.0f);
  CHECK(wavelength_pdf<Scalar>(830.1f) == 0.0f);
}

TEST_CASE("wavelengths: registers agree with single numbers") {
  const WideFloat u = wide_floats([](int lane) { return (static_cast<float>(lane) + 0.5f) / kWidth; });
  const Wavelengths<Wide> wide = sample_wavelengths<Wide>(u);
  for (int lane = 0; lane < kWidth; ++lane) {
    const Wavelengths<Scalar> one = sample_wavelengths<Scalar>(u[lane]);
    CHECK(difference(wide.lambda.c0[lane], one.lambda.c0) < 1e-6);
    CHECK(difference(wide.lambda.c3[lane], one.lambda.c3) < 1e-6);
    CHECK(difference(wide.pdf.c1[lane], one.pdf.c1) < 1e-6);
    CHECK(difference(wavelength_pdf<Wide>(wide.lambda.c2)[lane], wavelength_pdf<Scalar>(one.lambda.c2)) < 1e-6);
  }
}

TEST_CASE("wavelengths: white light is a quiet estimate") {
  // Variance over squared mean of the sum of red, green and blue under D65, against four uniform wavelengths.
  const auto variance = [](auto&& lambda_and_pdf) {
    double mean = 0, squares = 0;
    constexpr int kSteps = 8192;
    for (int i = 0; i < kSteps; ++i) {
      const auto [lambda, pdf] = lambda_and_pdf((static_cast<float>(i) + 0.5f) / kSteps);
      double estimate = 0;
      for (std::size_t k = 0; k < 4; ++k) {
        const Vec3f rgb = xyz_to_rec709(cie_1931_xyz(lambda[k])) * (cie_d65(lambda[k]) / pdf[k]);
        estimate += static_cast<double>(rgb.x + rgb.y + rgb.z) / 4;
      }
      mean += estimate / kSteps;
      squares += estimate * estimate / kSteps;
    }
    return squares / (mean * mean) - 1;
  };
  const double sampled = variance([](float u) {
    const Wavelengths<Scalar> w = sample_wavelengths<Scalar>(u);
    return std::pair{values(w.lambda), values(w.pdf)};
  });
  const double uniform = variance([](float u) {
    std::pair<std::array<float, 4>, std::array<float, 4>> w;
    for (std::size_t k = 0; k < 4; ++k) {
      w.first[k] = 360.0f + 470.0f * std::fmod(u + 0.25f * static_cast<float>(k), 1.0f);
      w.second[k] = 1.0f / 470.0f;
    }
    return w;
  });
  CHECK(sampled < 0.5 * uniform);
}

TEST_CASE("wavelengths: the balance over the four counts each path once") {
  CHECK(hero_balance(Spectrum4(1.0f)) == 1.0f);
  CHECK(hero_balance(Spectrum4(1, 0, 0, 0)) == 4.0f);
  // Two strategies with unequal densities p and q that both reach f: p f/mean + q f/mean weighs f by 1 on average.
  const float p = 0.3f, q = 0.9f;
  const float by_first = hero_balance(Spectrum4(1, q / p, 1, q / p)) / p;
  const float by_second = hero_balance(Spectrum4(1, p / q, 1, p / q)) / q;
  CHECK(0.5f * (p * by_first + q * by_second) == doctest::Approx(1));
}
