// The hair BSDF: its terms against closed forms, its energy, and properties beyond the tests of all BSDFs.
#include "kernels/bsdf/hair.h"

#include "kernels/stages/adjoint.h"
#include "tests/support/bsdf_testing.h"
#include "tests/support/capture.h"
#include "tests/support/near.h"

namespace sheaf::test_bsdf_hair {

namespace {

using Hair = HairBsdf<Scalar>;
using Angles = hair_detail::FiberAngles<Scalar>;

constexpr int kTests = 60;

Hair hair(float longitudinal, float azimuthal, float sigma_a, float tilt = 0.035f) {
  Hair bsdf;
  bsdf.absorption = Spectrum4(sigma_a);
  bsdf.eumelanin_absorption = bsdf.pheomelanin_absorption = Spectrum4(0.0f);
  bsdf.scale = 1;
  bsdf.eumelanin = bsdf.pheomelanin = 0;
  bsdf.by_reflectance = bsdf.fourth = 0;
  bsdf.longitudinal_roughness = longitudinal;
  bsdf.azimuthal_roughness = azimuthal;
  bsdf.tilt = tilt;
  bsdf.eta = 1.55f;
  return bsdf;
}

Angles at(double theta) { return Angles(Vec3f{0, std::sin(float(theta)), std::cos(float(theta))}); }

/// Integral of f over [from, to] by Simpson's rule.
template <class F> double integral(double from, double to, int steps, F&& f) {
  double sum = 0;
  for (int i = 0; i <= 2 * steps; ++i)
    sum += (i == 0 || i == 2 * steps ? 1 : i % 2 == 1 ? 4 : 2) * f(from + (to - from) * i / (2 * steps));
  return sum * (to - from) / (6 * steps);
}

constexpr double kHalfTurn = 3.141592653589793;

}  // namespace

TEST_CASE("hair: the Bessel function matches tabulated values") {
  // Abramowitz and Stegun 1964, table 9.8: exp(-x) I0(x).
  const std::pair<float, double> table[] = {{0.0f, 1.0},          {0.5f, 0.6450352706}, {1.0f, 0.4657596077},
                                            {2.0f, 0.3085083225}, {3.0f, 0.2430003542}, {5.0f, 0.1835408126},
                                            {10.0f, 0.1278333372}};
  for (const auto& [x, expected] : table) {
    const double scale = x < hair_detail::kSmallBessel ? std::exp(-double(x)) : 1.0;
    CHECK(scale * hair_detail::scaled_bessel_i0(x) == near(expected, 2e-5));
  }
}

TEST_CASE("hair: longitudinal lobes integrate to one and are centered on the specular cone") {
  for (const float v : {2e-4f, 0.01f, 0.3f, 2.0f, 80.0f})
    for (const double theta : {0.0, 0.6, -1.2, 1.5}) {
      CAPTURE(v);
      CAPTURE(theta);
      const auto density = [&](double t) {
        return double(hair_detail::longitudinal<Scalar>(at(theta), at(t), v)) * std::cos(t);
      };
      CHECK(integral(-kHalfTurn / 2, kHalfTurn / 2, 4000, density) == near(1, 1e-4));
    }
  // The mean of sin(theta) under a von Mises-Fisher distribution around -theta: coth(1 / v) - v times sin(-theta).
  const double v = 0.3, theta = 0.6;
  const double sine = integral(-kHalfTurn / 2, kHalfTurn / 2, 4000, [&](double t) {
    return double(hair_detail::longitudinal<Scalar>(at(theta), at(t), float(v))) * std::cos(t) * std::sin(t);
  });
  CHECK(sine == near(-(1 / std::tanh(1 / v) - v) * std::sin(theta), 1e-4));
}

TEST_CASE("hair: azimuthal lobes integrate to one and are periodic and are sampled by inversion") {
  for (const float s : {0.002f, 0.05f, 0.6f, 4.0f}) {
    CAPTURE(s);
    const hair_detail::TrimmedLogistic<float> lobe(s);
    CHECK(integral(-kHalfTurn, kHalfTurn, 20000, [&](double x) { return double(lobe.density(float(x))); }) ==
          near(1, 1e-4));
    CHECK(lobe.density(1.0f) == near(lobe.density(1.0f - 2 * float(kHalfTurn)), 2e-2));
    for (const float u : {0.01f, 0.3f, 0.5f, 0.9f}) {
      const double x = double(lobe.sample(u));
      CHECK(integral(-kHalfTurn, x, 20000, [&](double t) { return double(lobe.density(float(t))); }) == near(u, 1e-3));
    }
  }
}

TEST_CASE("hair: samples follow their pdf for rough and smooth fibers") {
  for (const auto& [longitudinal, azimuthal] : {std::pair{0.9f, 0.6f}, {0.3f, 0.3f}}) {
    CAPTURE_BINDING(longitudinal);
    check_bsdf_sampling(hair(longitudinal, azimuthal, 0.4f), kTests);
    check_bsdf_weights(hair(longitudinal, azimuthal, 0.4f), 1e-3);
  }
}

TEST_CASE("hair: fibers without absorption scatter all light") {
  for (const float roughness : {0.05f, 0.1f, 0.3f, 0.6f, 1.0f})
    for (const float tilt : {0.0f, 0.035f, 0.2f}) {
      CAPTURE(roughness);
      CAPTURE(tilt);
      const Hair bsdf = hair(roughness, 0.5f * roughness + 0.2f, 0, tilt);
      check_white_furnace(bsdf, true);
      // The value then equals the pdf up to rounding, because all lobes are sampled with their exact weights.
      for (std::uint32_t i = 0; i < 100; ++i) {
        const Vec3f wo = random_direction(31, i);
        const auto [f, pdf] = bsdf.evaluate(wo, random_direction(32, i));
        CHECK(f.c1 == near(pdf, 1e-3));
      }
    }
}

TEST_CASE("hair: absorbed and scattered light add up to the incident light") {
  // Through the center of a fiber: Fresnel reflectance at normal incidence, and segments of one diameter each.
  const double f = std::pow((1.55 - 1) / (1.55 + 1), 2);
  for (const float sigma_a : {0.2f, 1.0f}) {
    const double t = std::exp(-2.0 * double(sigma_a)), albedo = f + (1 - f) * (1 - f) * t / (1 - t * f);
    CHECK(sampled_albedo(hair(0.3f, 0.3f, sigma_a), {0, 0, 1}) == near(albedo, 5e-3));
    CHECK(sampled_albedo(hair(0.3f, 0.3f, sigma_a), {0, 0, -1}) == near(albedo, 5e-3));
  }
}

TEST_CASE("hair: smooth fibers scatter as a glass cylinder does") {
  // Transmission through the center continues at the mirrored inclination. Reflection off the center mirrors at the
  // normal.
  const Hair bsdf = hair(0.03f, 0.03f, 0, 0);
  const auto value = [&](Vec3f wo, Vec3f wi) { return bsdf.evaluate(wo, normalize(wi)).f_cos.c1; };
  const Vec3f wo = normalize(Vec3f{0, 0.4f, 1}), through{0, -0.4f, -1};
  CHECK(value(wo, through) > 10.0f);
  CHECK(value(wo, through) > 4 * value(wo, {0.3f, -0.4f, -1}));
  CHECK(value(wo, through) > 4 * value(wo, {0, 0.0f, -1}));
  const Vec3f slanted = normalize(Vec3f{0.8f, 0, 0.6f});
  CHECK(value(slanted, {-0.8f, 0, 0.6f}) > 4 * value(slanted, {-0.6f, 0, 0.8f}));
  // Refraction by Snell's law: light that enters at gamma exits rotated by pi + 2 (gamma_t - gamma).
  const double gamma = std::atan2(-0.8, 0.6), refracted = std::asin(std::sin(gamma) / 1.55);
  const double leaving = gamma + kHalfTurn + 2 * (refracted - gamma);
  const Vec3f out{-std::sin(float(leaving)), 0, std::cos(float(leaving))};
  CHECK(value(slanted, out) > 10.0f);
  CHECK(value(slanted, out) > 4 * value(slanted, {-out.x, 0, out.z}));
}

TEST_CASE("hair: tilted scales shift reflection by twice their angle and transmission by once in reverse") {
  const Vec3f wo{0, 0, 1};
  const auto brightest = [&](float side) {
    float best = 0, where = 0;
    const Hair bsdf = hair(0.05f, 0.05f, 0, 0.1f);
    for (float t = -0.6f; t < 0.6f; t += 0.005f)
      if (const float v = bsdf.evaluate(wo, {0, std::sin(t), side * std::cos(t)}).f_cos.c1; v > best)
        best = v, where = t;
    return where;
  };
  CHECK(brightest(1) == near(0.2, 0.1));
  CHECK(brightest(-1) == near(-0.1, 0.1));
}

TEST_CASE("hair: values match Mitsuba") {
  // Mitsuba 3.9.1, scalar_rgb. Its Bessel function is up to 0.5 % too small above 12.
  Hair brown = hair(0.3f, 0.3f, 0, 2 * kPi / 180);
  brown.eta = 1.55f / 1.000277f;
  brown.eumelanin = 1.3f, brown.pheomelanin = 0.2f;
  brown.eumelanin_absorption = {0.419f, 0.697f, 1.37f, 0}, brown.pheomelanin_absorption = {0.187f, 0.4f, 1.05f, 0};
  Hair dyed = hair(0.15f, 0.5f, 0, 8 * kPi / 180);
  dyed.eta = 1.4f / 1.000277f;
  dyed.absorption = {0.1f, 0.3f, 0.9f, 0}, dyed.scale = 0.5f;
  const auto check = [](const Hair& bsdf, Vec3f wo, Vec3f wi, Vec3f expected) {
    const auto f = bsdf.evaluate(wo, wi).f_cos;
    CHECK(f.c0 == near(expected.x, 1e-3));
    CHECK(f.c1 == near(expected.y, 1e-3));
    CHECK(f.c2 == near(expected.z, 1e-3));
    CHECK(f.c3 == 0.0f);
  };
  check(brown, {0.98888886f, 0.0999422371f, 0.110047348f}, {-0.752621949f, 0.656171262f, 0.054767631f},
        {0.07925422f, 0.07900454f, 0.07896546f});
  check(dyed, {-0.488092989f, -0.864957273f, 0.116679534f}, {0.48997581f, 0.797995329f, 0.350894809f},
        {0.05331841f, 0.03372313f, 0.0199863f});
  check(dyed, {-0.385407418f, -0.899510086f, 0.205773488f}, {0.151130691f, 0.987936616f, 0.0337756984f},
        {4.78274536f, 4.76909113f, 4.75919294f});
  // From behind the normal, a direction that does not occur for rays that hit a curve.
  check(dyed, {0.965376496f, -0.0973185003f, -0.242027655f}, {0.498614341f, -0.79011929f, 0.356504202f},
        {0.03982041f, 0.02980448f, 0.01249758f});
}

TEST_CASE("hair: photons agree with paths although the model is not reciprocal") {
  const Hair bsdf = hair(0.4f, 0.4f, 0.5f);
  const auto f = [&](Vec3f wo, Vec3f wi) { return bsdf.evaluate(wo, wi).f_cos.c0 / std::fabs(wi.z); };
  const auto photon = [&](Vec3f wo, Vec3f wi) { return adjoint_f_cos<Scalar>(bsdf, wo, wi).c0 / std::fabs(wi.z); };
  const Vec3f camera = normalize(Vec3f{0.7f, 0.2f, 0.5f}), light = normalize(Vec3f{-0.2f, -0.5f, 0.9f});
  CHECK(std::fabs(f(camera, light) / f(light, camera) - 1) > 0.02f);
  CHECK(photon(light, camera) == near(f(camera, light), 1e-5));
  // Behind the fiber: the normal at the photon is opposite to the one that the camera sees.
  const auto rotated = [](Vec3f w) { return Vec3f{-w.x, w.y, -w.z}; };
  CHECK(photon(light, rotated(camera)) == near(f(camera, rotated(light)), 1e-5));
}

TEST_CASE("hair: absorption follows from the color of dense hair") {
  Hair bsdf = hair(0.3f, 0.3f, 0);
  const Vec3f wo = normalize(Vec3f{0.1f, 0.2f, 0.9f}), wi = normalize(Vec3f{0.1f, -0.3f, -0.9f});
  // Chiang et al. 2016: at azimuthal roughness 0.3 the logarithm is divided by 5.969 - 0.215 0.3 + 2.532 0.3^2 - ...
  const double divisor = 5.969 - 0.215 * 0.3 + 2.532 * 0.09 - 10.73 * 0.027 + 5.574 * 0.0081 + 0.245 * 0.00243;
  bsdf.absorption = Spectrum4(static_cast<float>(std::pow(std::log(0.25) / divisor, 2)));
  const float expected = bsdf.evaluate(wo, wi).f_cos.c2;
  bsdf.absorption = Spectrum4(0.25f);
  bsdf.by_reflectance = 1;
  CHECK(bsdf.evaluate(wo, wi).f_cos.c2 == near(expected, 1e-4));
  bsdf.by_reflectance = 0;
  CHECK(std::fabs(bsdf.evaluate(wo, wi).f_cos.c2 / expected - 1) > 0.01f);
}

}  // namespace sheaf::test_bsdf_hair
