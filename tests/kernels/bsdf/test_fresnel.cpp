// Fresnel reflectance against closed forms and against complex arithmetic in double precision.
#include "kernels/bsdf/fresnel.h"

#include "tests/support/near.h"
#include "tests/support/records_testing.h"

#include <doctest/doctest.h>

#include <cmath>
#include <complex>
#include <vector>

namespace sheaf::test_fresnel {

namespace {

constexpr double kIndices[] = {1.0003, 1.1, 1.33, 1.5, 2.4, 1 / 1.33, 1 / 1.5, 1 / 2.4};

/// Fresnel's sine and tangent laws; `relative`: index of the far side over that of the near side.
double dielectric_reflectance(double cos_i, double relative) {
  const double angle_i = std::acos(cos_i), sin_t = std::sin(angle_i) / relative;
  if (sin_t >= 1) return 1;
  const double angle_t = std::asin(sin_t);
  if (angle_i < 1e-6) return std::pow((relative - 1) / (relative + 1), 2);
  const double s = std::sin(angle_i - angle_t) / std::sin(angle_i + angle_t);
  const double p = std::tan(angle_i - angle_t) / std::tan(angle_i + angle_t);
  return 0.5 * (s * s + p * p);
}

/// Reflectance from the complex amplitudes of both polarizations.
double conductor_reflectance(double cos_i, double eta, double k) {
  using Complex = std::complex<double>;
  const Complex index(eta, k), index2 = index * index;
  const Complex root = std::sqrt(index2 - Complex(1 - cos_i * cos_i));
  const Complex s = (cos_i - root) / (cos_i + root);
  const Complex p = (index2 * cos_i - root) / (index2 * cos_i + root);
  return 0.5 * (std::norm(s) + std::norm(p));
}

/// Cosines from grazing to normal incidence.
std::vector<float> cosines() {
  std::vector<float> out = {0.0f, 1e-6f, 1e-4f, 1e-2f};
  for (int i = 1; i <= 200; ++i) out.push_back(static_cast<float>(i) / 200.0f);
  return out;
}

}  // namespace

TEST_CASE("fresnel: dielectrics match the sine and tangent laws from both sides") {
  double worst = 0;
  for (const double eta : kIndices)
    for (const float c : cosines())
      for (const float cos_i : {c, -c}) {
        const double relative = cos_i < 0 ? 1 / eta : eta;
        // Near the critical angle the slope of the reflectance is unbounded.
        if (c == 0.0f || std::fabs((1 - double(c) * c) / (relative * relative) - 1) < 1e-3) continue;
        const float found = fresnel_dielectric<Scalar>(cos_i, static_cast<float>(eta)).reflectance;
        worst = std::max(worst, std::fabs(found - dielectric_reflectance(c, relative)));
      }
  CHECK(worst < 2e-5);
}

/// Error of the squared sine of the refracted direction in single precision, for sines near 1.
constexpr double kSineError = 2.5e-7;

TEST_CASE("fresnel: dielectrics have their known reflectance at normal and Brewster and grazing incidence") {
  for (const double eta : kIndices) {
    const float e = static_cast<float>(eta);
    const double normal = std::pow((eta - 1) / (eta + 1), 2);
    // The amplitude is rounded by about 1e-7, the index included
    const Near expected = within(normal, 1e-4 * normal + 2e-7 * std::sqrt(normal));
    CHECK(fresnel_dielectric<Scalar>(1.0f, e).reflectance == expected);
    CHECK(fresnel_dielectric<Scalar>(-1.0f, e).reflectance == expected);
    // Brewster's angle, tan = eta: the parallel component is not reflected.
    const double s = (1 - eta * eta) / (1 + eta * eta);
    const float brewster = static_cast<float>(std::cos(std::atan(eta)));
    CHECK(fresnel_dielectric<Scalar>(brewster, e).reflectance == near(0.5 * s * s, 1e-3));
    CHECK(fresnel_dielectric<Scalar>(0.0f, e).reflectance == 1.0f);
    CHECK(fresnel_dielectric<Scalar>(-0.0f, e).reflectance == 1.0f);
  }
}

TEST_CASE("fresnel: refracted cosines obey Snell's law and have the opposite sign") {
  for (const double eta : kIndices)
    for (const float c : cosines())
      for (const float cos_i : {c, -c}) {
        if (c == 0.0f) continue;
        const auto f = fresnel_dielectric<Scalar>(cos_i, static_cast<float>(eta));
        const double relative = cos_i > 0 ? eta : 1 / eta;
        CHECK(f.eta == near(relative, 1e-6));
        const double sin2_t = (1 - double(c) * c) / (relative * relative);
        if (sin2_t >= 1) {
          if (sin2_t > 1 + 1e-5) CHECK(f.reflectance == 1.0f);
          continue;
        }
        CHECK(double(f.cos_transmitted) * f.cos_transmitted == within(1 - sin2_t, 2e-5 * (1 - sin2_t) + kSineError));
        CHECK(f.cos_transmitted * cos_i <= 0.0f);
      }
}

TEST_CASE("fresnel: the reflectance of a dielectric is the same along the reversed path") {
  for (const double eta : kIndices)
    for (const float c : cosines()) {
      const auto there = fresnel_dielectric<Scalar>(c, static_cast<float>(eta));
      if (there.reflectance == 1.0f || c < 1e-3f) continue;
      const auto back = fresnel_dielectric<Scalar>(there.cos_transmitted, static_cast<float>(eta));
      // Relative error of the cosine; the reflectance changes by at most its fourth power
      const double error = 1e-3 + kSineError / (2 * double(c) * c);
      CHECK(back.reflectance == near(there.reflectance, 4 * error));
      CHECK(back.cos_transmitted == near(c, error));
      CHECK(back.eta * there.eta == near(1, 1e-6));
    }
}

TEST_CASE("fresnel: matched indices reflect nothing and do not refract") {
  for (const float c : cosines()) {
    if (c == 0.0f) continue;
    const auto f = fresnel_dielectric<Scalar>(c, 1.0f);
    CHECK(f.cos_transmitted <= 0.0f);
    CHECK(double(f.cos_transmitted) * f.cos_transmitted == within(double(c) * c, 1e-5 * c * c + kSineError));
    if (c < 1e-3f) continue;  // 1 - cos^2 rounds to 1 in single precision
    CHECK(f.reflectance == 0.0f);
    CHECK(fresnel_dielectric<Scalar>(-c, 1.0f).reflectance == 0.0f);
  }
}

TEST_CASE("fresnel: conductors match the formula in complex arithmetic") {
  double worst = 0;
  for (const double eta : {0.05, 0.2, 1.0, 1.5, 3.0})
    for (const double k : {0.1, 1.0, 3.5, 7.0})
      for (const float c : cosines()) {
        const float r = fresnel_conductor(c, static_cast<float>(eta), static_cast<float>(k));
        worst = std::max(worst, std::fabs(r - conductor_reflectance(c, eta, k)));
        CHECK(r >= 0.0f);
        CHECK(r <= 1.0f + 1e-6f);
      }
  CHECK(worst < 1e-5);
}

TEST_CASE("fresnel: conductors have their known reflectance in limiting cases") {
  CHECK(fresnel_conductor(1.0f, 0.2f, 3.0f) == near((0.64 + 9) / (1.44 + 9), 1e-6));
  CHECK(fresnel_conductor(0.0f, 0.2f, 3.0f) == near(1, 1e-6));
  for (const float c : cosines()) {
    CHECK(fresnel_conductor(c, 0.0f, 1.0f) == near(1, 1e-6));
    CHECK(fresnel_conductor(c, 1.5f, 0.0f) == near(fresnel_dielectric<Scalar>(c, 1.5f).reflectance, 1e-4));
  }
}

TEST_CASE("fresnel: SIMD results equal scalar ones") {
  double worst = 0;
  for (std::uint32_t i = 0; i < 4000; i += kWidth) {
    const auto u = wide_random(5, i);
    const WideFloat cos_i = u.x * WideFloat(2.0f) - WideFloat(1.0f), eta = WideFloat(0.4f) + u.y * WideFloat(2.0f);
    const auto wide = fresnel_dielectric<Wide>(cos_i, eta);
    const WideFloat metal = fresnel_conductor(u.x, eta, u.z * WideFloat(5.0f));
    for (int lane = 0; lane < kWidth; ++lane) {
      const auto one = fresnel_dielectric<Scalar>(cos_i[lane], eta[lane]);
      worst = std::max({worst, difference(wide.reflectance[lane], one.reflectance), difference(wide.eta[lane], one.eta),
                        difference(metal[lane], fresnel_conductor(u.x[lane], eta[lane], u.z[lane] * 5.0f))});
      // Near the critical angle the square root magnifies rounding errors.
      if (std::fabs(one.cos_transmitted) > 1e-2f)
        worst = std::max(worst, difference(wide.cos_transmitted[lane], one.cos_transmitted));
    }
  }
  CHECK(worst < 2e-4);
}

}  // namespace sheaf::test_fresnel
