// The Phong, Ward and Oren-Nayar models, diffuse transmission and single-scattering slabs against their published
// formulas in double precision.
#include "kernels/bsdf/diffuse_transmitter.h"
#include "kernels/bsdf/hanrahan_krueger.h"
#include "kernels/bsdf/phong.h"
#include "kernels/bsdf/rough_diffuse.h"
#include "kernels/bsdf/ward.h"

#include "tests/support/bsdf_testing.h"
#include "tests/support/near.h"

namespace sheaf::test_bsdf_lobes {

namespace {

using Variant = WardDescription::Variant;
constexpr double kPiD = 3.14159265358979323846;
constexpr int kSamplingTests = 1 + 5 + 5 * 2 + 10 + 10;

PhongBsdf<Scalar> phong(float exponent, float diffuse, float specular) {
  PhongBsdf<Scalar> bsdf;
  bsdf.diffuse = {diffuse, 0.5f * diffuse, 0.2f * diffuse, 0};
  bsdf.specular = {specular, specular, 0.3f * specular, 0};
  bsdf.exponent = exponent;
  return bsdf;
}

WardBsdf<Scalar> ward(Variant variant, float alpha_u, float alpha_v, float diffuse, float specular) {
  WardBsdf<Scalar> bsdf;
  bsdf.diffuse = {diffuse, 0.5f * diffuse, 0.2f * diffuse, 0};
  bsdf.specular = {specular, specular, 0.3f * specular, 0};
  bsdf.alpha_u = alpha_u;
  bsdf.alpha_v = alpha_v;
  bsdf.variant = static_cast<std::uint32_t>(variant);
  return bsdf;
}

RoughDiffuseBsdf<Scalar> rough_diffuse(float alpha, float reflectance, bool fast) {
  RoughDiffuseBsdf<Scalar> bsdf;
  bsdf.reflectance = {reflectance, 0.5f * reflectance, 0.2f * reflectance, 0};
  bsdf.alpha = alpha;
  bsdf.fast = fast ? 1 : 0;
  return bsdf;
}

HanrahanKruegerBsdf<Scalar> slab(float sigma_s, float sigma_a, float thickness, float g) {
  HanrahanKruegerBsdf<Scalar> bsdf;
  bsdf.first = {sigma_s, 0.5f * sigma_s, 2 * sigma_s, 0};
  bsdf.second = {sigma_a, sigma_a, sigma_a, 0};
  bsdf.by_albedo = 0;
  bsdf.thickness = thickness;
  bsdf.g = g;
  return bsdf;
}

/// A slab with the same coefficients at all wavelengths.
HanrahanKruegerBsdf<Scalar> gray_slab(float sigma_s, float thickness, float g) {
  HanrahanKruegerBsdf<Scalar> bsdf = slab(sigma_s, 0, thickness, g);
  bsdf.first = Spectrum4(sigma_s);
  return bsdf;
}

/// A slab without its delta lobe: unscattered light counts as absorbed.
struct Scattering : HanrahanKruegerBsdf<Scalar> {
  BsdfSample<Scalar> sample(Vec3f wo, const Random4<Scalar>& u) const {
    auto s = HanrahanKruegerBsdf<Scalar>::sample(wo, u);
    s.valid = s.valid && s.pdf_solid_angle > 0;
    return s;
  }
};

/// f over reflectance / pi by the equations of Oren and Nayar, in double precision.
double oren_nayar(double theta_o, double theta_i, double phi, double alpha, double rho, bool fast) {
  const double s2 = 0.5 * alpha * alpha, a = std::max(theta_o, theta_i), b = std::min(theta_o, theta_i);
  const double c1 = 1 - 0.5 * s2 / (s2 + 0.33);
  if (fast) return c1 + 0.45 * s2 / (s2 + 0.09) * std::max(0.0, std::cos(phi)) * std::sin(a) * std::tan(b);
  const double third = std::cos(phi) >= 0 ? 0.0 : std::pow(2 * b / kPiD, 3);
  const double c2 = 0.45 * s2 / (s2 + 0.09) * (std::sin(a) - third);
  const double c3 = 0.125 * s2 / (s2 + 0.09) * std::pow(4 * a * b / (kPiD * kPiD), 2);
  const double once =
      c1 + std::cos(phi) * c2 * std::tan(b) + (1 - std::fabs(std::cos(phi))) * c3 * std::tan((a + b) / 2);
  return once + 0.17 * rho * s2 / (s2 + 0.13) * (1 - std::cos(phi) * std::pow(2 * b / kPiD, 2));
}

/// f times cosine of a slab, by the midpoint rule over the depth of the single scattering vertex.
double slab_by_depth(double sigma_s, double sigma_t, double thickness, double g, Vec3f wo, Vec3f wi) {
  const double o = std::fabs(double(wo.z)), i = std::fabs(double(wi.z)), cosine = -double(dot(wo, wi));
  const double phase = (1 - g * g) / (4 * kPiD * std::pow(1 + g * g - 2 * g * cosine, 1.5));
  constexpr int kSteps = 4000;
  double sum = 0;
  for (int k = 0; k < kSteps; ++k) {
    const double in = (k + 0.5) / kSteps * thickness, out = wo.z * wi.z > 0 ? in : thickness - in;
    sum += std::exp(-sigma_t * (in / i + out / o)) * thickness / kSteps;
  }
  return sigma_s * phase * sum / o;
}

}  // namespace

TEST_SUITE_BEGIN("slow");

TEST_CASE("phong: samples have consistent pdfs and weights and values are reciprocal without energy gain") {
  for (const float exponent : {0.0f, 8.0f, 300.0f}) {
    CAPTURE(exponent);
    const auto bsdf = phong(exponent, 0.3f, 0.6f);
    check_bsdf_weights(bsdf);
    check_bsdf_reciprocity(bsdf);
    check_bsdf_finite(bsdf);
    check_white_furnace(phong(exponent, 0, 1), false);
  }
  check_bsdf_peak_sampling(phong(2000, 0.1f, 0.8f), direction_of(0.8, 0.3), direction_of(0.8, 0.3 + kPiD), 0.06,
                           kSamplingTests);
}

TEST_CASE("phong: values match computations by hand") {
  const Vec3f wo{0.6f, 0, 0.8f}, wi{0, 0.6f, 0.8f};
  // The mirror direction of wo is (-0.6, 0, 0.8); its cosine with wi is 0.64.
  const double lobe = 12 / (2 * kPiD) * std::pow(0.64, 10);
  CHECK(phong(10, 0.3f, 0.6f).evaluate(wo, wi).f_cos.c0 == near(0.8 * (0.3 / kPiD + 0.6 * lobe), 1e-5));
  CHECK(is_black(phong(10, 0.3f, 0.6f).evaluate(wo, {0, 0.6f, -0.8f}).f_cos));
  // At normal incidence the whole lobe is above the surface. Its normalization (n + 2) / (2 pi) cancels the cosine, so
  // a white lobe loses nothing.
  CHECK(sampled_albedo(phong(10, 0, 1), {0, 0, 1}) == near(1, 0.01));
}

TEST_CASE("ward: samples have consistent pdfs and weights and values are reciprocal") {
  for (const Variant variant : {Variant::kWard, Variant::kDuer, Variant::kBalanced})
    for (const auto& [u, v] : {std::pair{0.2f, 0.2f}, std::pair{0.5f, 0.15f}}) {
      const auto bsdf = ward(variant, u, v, 0.2f, 0.6f);
      check_bsdf_weights(bsdf, 1e-3);
      check_bsdf_reciprocity(bsdf);
      check_bsdf_finite(bsdf);
    }
  check_bsdf_sampling_with_edges(ward(Variant::kBalanced, 0.6f, 0.3f, 0.2f, 0.6f), kSamplingTests);
}

TEST_CASE("ward: the balanced variant does not gain energy and all variants agree at normal incidence") {
  for (const float alpha : {0.05f, 0.2f, 0.5f}) {
    CAPTURE(alpha);
    check_white_furnace(ward(Variant::kBalanced, alpha, alpha, 0, 1), false);
    check_white_furnace(ward(Variant::kBalanced, alpha, 0.5f * alpha, 0, 1), false);
  }
  for (const Variant variant : {Variant::kWard, Variant::kDuer, Variant::kBalanced})
    CHECK(ward(variant, 0.3f, 0.1f, 0, 1).evaluate({0, 0, 1}, {0, 0, 1}).f_cos.c0 == near(1 / (4 * kPiD * 0.03), 1e-5));
}

TEST_CASE("ward: values match computations by hand") {
  const Vec3f wo{0.6f, 0, 0.8f}, wi{0, 0.6f, 0.8f};
  // The unnormalized half vector is (0.6, 0.6, 1.6).
  const double t2 = (std::pow(0.6 / 0.3, 2) + std::pow(0.6 / 0.2, 2)) / (1.6 * 1.6);
  const double e = std::exp(-t2) / (kPiD * 0.3 * 0.2), base = 0.2 / kPiD;
  const auto value = [&](Variant v) { return double(ward(v, 0.3f, 0.2f, 0.2f, 0.6f).evaluate(wo, wi).f_cos.c0) / 0.8; };
  CHECK(value(Variant::kWard) == near(base + 0.6 * e / (4 * 0.8), 1e-5));
  CHECK(value(Variant::kDuer) == near(base + 0.6 * e / (4 * 0.64), 1e-5));
  CHECK(value(Variant::kBalanced) == near(base + 0.6 * e * 3.28 / std::pow(1.6, 4), 1e-5));
}

TEST_CASE("rough diffuse: values match the formulas of Oren and Nayar") {
  for (const bool fast : {false, true})
    for (const float alpha : {0.0f, 0.2f, 0.9f}) {
      const auto bsdf = rough_diffuse(alpha, 0.6f, fast);
      for (std::uint32_t i = 0; i < 300; ++i) {
        Vec3f wo = random_direction(61, i), wi = random_direction(62, i);
        wo.z = std::fabs(wo.z), wi.z = std::fabs(wi.z);
        const double phi = std::atan2(double(wo.y), double(wo.x)) - std::atan2(double(wi.y), double(wi.x));
        const auto expected = [&](double rho) {
          return rho / kPiD * double(wi.z) *
                 std::max(0.0,
                          oren_nayar(std::acos(double(wo.z)), std::acos(double(wi.z)), phi, double(alpha), rho, fast));
        };
        const Spectrum4 f = bsdf.evaluate(wo, wi).f_cos;
        CHECK(f.c0 == near(expected(0.6), 2e-3));
        CHECK(f.c1 == near(expected(0.3), 2e-3));
      }
    }
}

TEST_CASE("rough diffuse: samples have consistent weights and a smooth surface is Lambertian") {
  check_bsdf_sampling(rough_diffuse(0.4f, 0.6f, false), kSamplingTests);
  for (const bool fast : {false, true}) {
    check_bsdf_weights(rough_diffuse(0.4f, 0.6f, fast));
    check_bsdf_finite(rough_diffuse(0.4f, 0.6f, fast));
    check_white_furnace(rough_diffuse(0, 1, fast), true);
  }
  check_bsdf_reciprocity(rough_diffuse(0.5f, 0.8f, true));
  // Slopes of 0.35: masking hardly exceeds interreflection between the facets.
  CHECK(sampled_albedo(rough_diffuse(0.5f, 1, false), {0, 0, 1}) == near(0.94, 0.05));
}

TEST_CASE("diffuse transmission: samples have consistent weights and conserve energy from both sides") {
  DiffuseTransmitterBsdf<Scalar> bsdf;
  bsdf.transmittance = {1, 0.5f, 0.2f, 0};
  check_bsdf_sampling(bsdf, kSamplingTests);
  check_bsdf_weights(bsdf);
  check_bsdf_reciprocity(bsdf);
  check_white_furnace(bsdf, true);
  CHECK(bsdf.evaluate({0, 0.6f, 0.8f}, {0.8f, 0, -0.6f}).f_cos.c1 == near(0.5 * 0.6 / kPiD, 1e-5));
  CHECK(bsdf.evaluate({0, 0.6f, -0.8f}, {0.8f, 0, 0.6f}).f_cos.c1 == near(0.5 * 0.6 / kPiD, 1e-5));
  CHECK(is_black(bsdf.evaluate({0, 0.6f, 0.8f}, {0.8f, 0, 0.6f}).f_cos));
}

TEST_CASE("hanrahan krueger: samples have consistent weights and values are reciprocal without energy gain") {
  for (const float g : {0.0f, 0.7f}) {
    CAPTURE(g);
    Scattering part;
    static_cast<HanrahanKruegerBsdf<Scalar>&>(part) = slab(2, 0.5f, 0.4f, g);
    if (g > 0) check_bsdf_sampling(part, kSamplingTests);
    check_bsdf_weights(part);
    check_bsdf_reciprocity(part);
    check_bsdf_finite(slab(2, 0.5f, 0.4f, g));
    check_white_furnace(gray_slab(2, 0.4f, g), false);
    // The slab is so thin that multiple scattering is negligible: light that is not scattered passes.
    CHECK(sampled_albedo(gray_slab(1e-3f, 0.1f, g), {0, 0.6f, 0.8f}) == near(1, 0.01));
  }
}

TEST_CASE("hanrahan krueger: values equal the integral over the depth of the scattering vertex") {
  for (std::uint32_t i = 0; i < 100; ++i) {
    const Vec3f wo = random_direction(63, i), wi = random_direction(64, i);
    if (std::fabs(wo.z) < 0.05f || std::fabs(wi.z) < 0.05f) continue;
    const auto f = slab(2, 0.5f, 0.4f, 0.3f).evaluate(wo, wi).f_cos;
    CHECK(f.c0 == near(slab_by_depth(2, 2.5, 0.4, 0.3, wo, wi), 1e-3));
    CHECK(f.c2 == near(slab_by_depth(4, 4.5, 0.4, 0.3, wo, wi), 1e-3));
  }
  const Vec3f wo{0.6f, 0, 0.8f};
  MeanVariance passed;
  for (std::uint32_t i = 0; i < 20000; ++i) {
    const auto s = slab(2, 0.5f, 0.4f, 0.3f).sample(wo, lane_random(65, i, 0));
    passed.add(s.pdf_solid_angle == 0 ? double(s.weight.c0) : 0.0);
    if (s.pdf_solid_angle == 0) CHECK(length(s.wi + wo) < 1e-6f);
  }
  CHECK(passed.p_value(std::exp(-2.5 * 0.4 / 0.8)) > significance_of_each(kSamplingTests));
  // Parametrized by extinction and albedo, the result is the same.
  HanrahanKruegerBsdf<Scalar> other = slab(2, 0.5f, 0.4f, 0.3f);
  other.first = {2.5f, 1.5f, 4.5f, 0};
  other.second = {0.8f, 1 / 1.5f, 4 / 4.5f, 0};
  other.by_albedo = 1;
  const Vec3f wi{0, -0.6f, 0.8f};
  CHECK(other.evaluate(wo, wi).f_cos.c2 == near(slab(2, 0.5f, 0.4f, 0.3f).evaluate(wo, wi).f_cos.c2, 1e-5));
}

TEST_SUITE_END();

}  // namespace sheaf::test_bsdf_lobes
