// BSDFs: sampling against pdfs, energy, reciprocity, and the laws of reflection and refraction.
#include "kernels/bsdf/list.h"

#include "tests/support/bsdf_testing.h"
#include "tests/support/near.h"

namespace sheaf::test_bsdf {

namespace {

template <template <class> class Bsdf, class Parameters> Bsdf<Scalar> make_bsdf(const Parameters& parameters) {
  Bsdf<Scalar> bsdf;
  static_cast<Parameters&>(bsdf) = parameters;
  return bsdf;
}

DiffuseBsdf<Scalar> diffuse(float r, float g, float b) {
  return make_bsdf<DiffuseBsdf>(DiffuseParameters<Scalar>{{r, g, b, 0}});
}
ConductorBsdf<Scalar> conductor(float eta, float k, float reflectance = 1) {
  return make_bsdf<ConductorBsdf>(ConductorParameters<Scalar>{Spectrum4(eta), Spectrum4(k), Spectrum4(reflectance)});
}
DielectricBsdf<Scalar> dielectric(float eta, float reflectance = 1, float transmittance = 1) {
  return make_bsdf<DielectricBsdf>(DielectricParameters<Scalar>{eta, Spectrum4(reflectance), Spectrum4(transmittance)});
}

/// Random numbers for which a dielectric reflects (0) or, if it can, transmits (just below 1).
constexpr Random4<Scalar> kReflect{0, 0, 0, 0}, kTransmit{0.9999999f, 0, 0, 0};

constexpr int kSamplingTests = 5;  // outgoing directions from which a diffuse surface scatters

}  // namespace

TEST_CASE("bsdf: diffuse samples follow their pdf") {
  check_bsdf_sampling(diffuse(0.8f, 0.4f, 0.1f), kSamplingTests);
  check_bsdf_weights(diffuse(0.8f, 0.4f, 0.1f));
}

TEST_CASE("bsdf: diffuse reflection is reciprocal and one-sided and conserves energy") {
  check_bsdf_reciprocity(diffuse(0.8f, 0.4f, 0.1f));
  check_white_furnace(diffuse(1, 1, 1), true);
  const auto f = diffuse(0.8f, 0.4f, 0.1f).evaluate({0.6f, 0, 0.8f}, {0, 0.8f, 0.6f}).f_cos;
  CHECK(f.c0 == near(0.8 * 0.6 / 3.14159265358979, 1e-6));
  CHECK(f.c1 == near(0.4 * 0.6 / 3.14159265358979, 1e-6));
  CHECK(f.c2 == near(0.1 * 0.6 / 3.14159265358979, 1e-6));
  for (const Vec3f wo : {Vec3f{0.6f, 0, -0.8f}, Vec3f{1, 0, 0}}) {
    CHECK(is_black(diffuse(1, 1, 1).evaluate(wo, {0, 0, 1}).f_cos));
    CHECK(diffuse(1, 1, 1).evaluate(wo, {0, 0, 1}).pdf_solid_angle == 0.0f);
    CHECK_FALSE(diffuse(1, 1, 1).sample(wo, {0.5f, 0.3f, 0.7f, 0.5f}).valid);
  }
  CHECK(is_black(diffuse(1, 1, 1).evaluate({0, 0, 1}, {0.6f, 0, -0.8f}).f_cos));
  CHECK(diffuse(1, 1, 1).evaluate({0, 0, 1}, {0.6f, 0, -0.8f}).pdf_solid_angle == 0.0f);
}

TEST_CASE("bsdf: conductors reflect by the Fresnel equations on the outside only") {
  for (const Vec3f wo : outgoing_directions()) {
    const auto s = conductor(0.2f, 3.0f, 0.5f).sample(wo, kReflect);
    CHECK(s.valid == (wo.z > 0));
    if (!s.valid) continue;
    CHECK(s.wi == Vec3f{-wo.x, -wo.y, wo.z});
    CHECK(s.weight.c1 == near(0.5 * fresnel_conductor(wo.z, 0.2f, 3.0f), 1e-6));
    CHECK(s.pdf_solid_angle == 0.0f);
    CHECK(s.eta_scale == 1.0f);
    CHECK(is_black(conductor(0.2f, 3.0f).evaluate(wo, s.wi).f_cos));
    CHECK(conductor(0.2f, 3.0f).evaluate(wo, s.wi).pdf_solid_angle == 0.0f);
  }
  check_white_furnace(conductor(0.2f, 3.0f), false);
  check_white_furnace(conductor(0, 1), true);
}

TEST_CASE("bsdf: each wavelength of a conductor has its own index of refraction") {
  const ConductorParameters<Scalar> parameters{{0.2f, 1.0f, 1.5f, 0}, {3.0f, 2.0f, 1.0f, 1}, {1, 0.5f, 0.25f, 0}};
  const auto s = make_bsdf<ConductorBsdf>(parameters).sample({0.6f, 0, 0.8f}, kReflect);
  CHECK(s.weight.c0 == near(fresnel_conductor(0.8f, 0.2f, 3.0f)));
  CHECK(s.weight.c1 == near(0.5 * fresnel_conductor(0.8f, 1.0f, 2.0f)));
  CHECK(s.weight.c2 == near(0.25 * fresnel_conductor(0.8f, 1.5f, 1.0f)));
  CHECK(s.weight.c3 == 0.0f);
}

TEST_CASE("bsdf: dielectrics refract by Snell's law in the plane of incidence") {
  for (const float eta : {1.5f, 2.4f, 1 / 1.5f})
    for (const Vec3f wo : outgoing_directions()) {
      const auto fresnel = fresnel_dielectric<Scalar>(wo.z, eta);
      const auto s = dielectric(eta).sample(wo, kTransmit);
      if (fresnel.reflectance > 0.999999f) continue;
      const double relative = wo.z > 0 ? eta : 1.0 / eta;
      CAPTURE(wo.z);
      REQUIRE(s.valid);
      CHECK(s.wi.z * wo.z < 0.0f);
      CHECK(length(s.wi) == near(1, 1e-5));
      CHECK(std::hypot(s.wi.x, s.wi.y) * relative == near(std::hypot(wo.x, wo.y), 1e-5));
      CHECK(s.wi.x * wo.y == near(s.wi.y * wo.x, 1e-5));
      CHECK(s.wi.x * wo.x + s.wi.y * wo.y <= 0.0f);
      CHECK(s.eta_scale == near(relative * relative, 1e-5));
      CHECK(s.weight.c0 == near(1 / (relative * relative), 1e-5));
    }
}

TEST_CASE("bsdf: light refracted into glass and out again regains its direction and radiance") {
  for (const float eta : {1.5f, 1 / 1.5f}) {
    const Vec3f wo = direction_of(0.9, 1.1);
    const auto in = dielectric(eta).sample(wo, kTransmit);
    const auto out = dielectric(eta).sample(in.wi, kTransmit);
    CHECK(record_difference<Vec3>(out.wi, wo) < 1e-5);
    CHECK(in.weight.c0 * out.weight.c0 == near(1, 1e-5));
    CHECK(in.eta_scale * out.eta_scale == near(1, 1e-5));
  }
}

TEST_CASE("bsdf: light beyond the critical angle is totally reflected") {
  const float critical = std::sqrt(1 - 1 / (1.5f * 1.5f));
  for (const float cos_theta : {critical * 0.999f, 0.5f * critical, 0.01f, 1e-4f}) {
    const Vec3f wo = direction_of(-cos_theta, 0.3);
    const auto s = dielectric(1.5f, 0.75f, 0.5f).sample(wo, kTransmit);
    CHECK(s.valid);
    CHECK(s.wi == Vec3f{-wo.x, -wo.y, wo.z});
    CHECK(s.weight.c0 == 0.75f);
    CHECK(s.eta_scale == 1.0f);
  }
  CHECK(dielectric(1.5f).sample(direction_of(-critical * 1.001, 0.3), kTransmit).wi.z > 0.0f);
}

TEST_CASE("bsdf: dielectrics choose reflection by the Fresnel reflectance and conserve energy") {
  constexpr int kDraws = 20000;
  for (const float eta : {1.5f, 1 / 1.5f})
    for (const Vec3f wo : outgoing_directions()) {
      int reflected = 0;
      for (std::uint32_t i = 0; i < kDraws; ++i) {
        const auto s = dielectric(eta, 0.75f, 0.5f).sample(wo, lane_random(21, i, 0));
        reflected += s.wi.z * wo.z > 0;
        const float scale = s.wi.z * wo.z > 0 ? 0.75f : 0.5f / s.eta_scale;
        CHECK(s.weight.c2 == near(scale, 1e-5));
      }
      const double fraction = fresnel_dielectric<Scalar>(wo.z, eta).reflectance;
      // Binomial counts; 10 cases for each index.
      const double threshold = student_t_threshold(significance_of_each(20), kDraws - 1);
      CHECK(std::fabs(reflected - kDraws * fraction) <= threshold * std::sqrt(kDraws * fraction * (1 - fraction)) + 1);
      CHECK(is_black(dielectric(eta).evaluate(wo, {0, 0, 1}).f_cos));
      CHECK(dielectric(eta).evaluate(wo, {0, 0, 1}).pdf_solid_angle == 0.0f);
    }
  check_white_furnace(dielectric(1.5f), true);
  check_white_furnace(dielectric(1 / 1.5f), true);
  check_white_furnace(dielectric(1.0f), true);
}

TEST_CASE("bsdf: SIMD results equal scalar ones") {
  const auto fraction = [](int lane, int k) {
    return static_cast<float>(lane + 1 + k) / static_cast<float>(kWidth + 4);
  };
  check_bsdf_lanes<DiffuseBsdf>(
      [&](int lane) { return diffuse(fraction(lane, 0), fraction(lane, 1), fraction(lane, 2)); });
  check_bsdf_lanes<ConductorBsdf>(
      [&](int lane) { return conductor(2 * fraction(lane, 0), 4 * fraction(lane, 1), fraction(lane, 2)); });
  check_bsdf_lanes<DielectricBsdf>(
      [&](int lane) { return dielectric(0.5f + 1.5f * fraction(lane, 0), fraction(lane, 1), fraction(lane, 2)); });
}

}  // namespace sheaf::test_bsdf
