// Rough conductors and dielectrics, the thin dielectric, and Nori's microfacet BRDF.
#include "kernels/bsdf/nori_microfacet.h"
#include "kernels/bsdf/rough_conductor.h"
#include "kernels/bsdf/rough_dielectric.h"
#include "kernels/bsdf/thin_dielectric.h"

#include "tests/support/bsdf_testing.h"
#include "tests/support/capture.h"
#include "tests/support/near.h"

namespace sheaf::test_bsdf_rough {

namespace {

template <template <class> class Bsdf, class Parameters> Bsdf<Scalar> make_bsdf(const Parameters& parameters) {
  Bsdf<Scalar> bsdf;
  static_cast<Parameters&>(bsdf) = parameters;
  return bsdf;
}

template <template <class> class Bsdf> Bsdf<Scalar> metal(float alpha_u, float alpha_v) {
  return make_bsdf<Bsdf>(RoughConductorParameters<Scalar>{
      {0.2f, 0.9f, 1.1f, 0}, {3.9f, 2.4f, 2.2f, 1}, {1, 0.9f, 0.8f, 0}, alpha_u, alpha_v});
}
template <template <class> class Bsdf>
Bsdf<Scalar> glass(float eta, float alpha_u, float alpha_v, float r = 1, float t = 1) {
  return make_bsdf<Bsdf>(RoughDielectricParameters<Scalar>{eta, Spectrum4(r), Spectrum4(t), alpha_u, alpha_v});
}
NoriMicrofacetBsdf<Scalar> nori(float kd, float alpha, float eta = 1.5f) {
  return make_bsdf<NoriMicrofacetBsdf>(NoriMicrofacetParameters<Scalar>{{kd, 0.5f * kd, 0.2f * kd, 0}, alpha, eta});
}
ThinDielectricBsdf<Scalar> pane(float eta, float r = 1, float t = 1) {
  return make_bsdf<ThinDielectricBsdf>(DielectricParameters<Scalar>{eta, Spectrum4(r), Spectrum4(t)});
}

constexpr int kSamplingTests = 5 * 2 * 3 + 10 * 2 * 4 + 5 * 4;  // directions, distributions, surfaces

template <template <class> class Bsdf> void check_metal() {
  for (const auto& [u, v] : {std::pair{0.15f, 0.15f}, std::pair{0.2f, 0.5f}, std::pair{1.0f, 1.0f}}) {
    CAPTURE_BINDING(u);
    check_bsdf_sampling_with_edges(metal<Bsdf>(u, v), kSamplingTests);
  }
  for (const auto& [u, v] : {std::pair{0.05f, 0.05f}, std::pair{0.1f, 0.4f}, std::pair{1.0f, 1.0f}}) {
    check_bsdf_weights(metal<Bsdf>(u, v), 5e-4);
    check_bsdf_reciprocity(metal<Bsdf>(u, v));
  }
  for (const float alpha : {1e-4f, 0.01f, 0.3f, 1.0f}) check_white_furnace(metal<Bsdf>(alpha, 0.5f * alpha), false);
  for (const float alpha : {1e-4f, 0.1f, 1.0f}) check_bsdf_finite(metal<Bsdf>(alpha, 0.3f));
  auto mirror = metal<Bsdf>(0.01f, 0.01f);
  mirror.eta = Spectrum4(0.0f);
  mirror.k = mirror.reflectance = Spectrum4(1.0f);
  const Vec3f wo = direction_of(0.7, 1);
  for (std::uint32_t i = 0; i < 100; ++i) {
    const auto s = mirror.sample(wo, lane_random(41, i, 0));
    CHECK(s.valid);
    CHECK(s.weight.c0 == near(1, 1e-3));  // hardly any masking
    // Of 100 normals of the GGX distribution, about one has a slope above 10 times the roughness
    CHECK(s.wi.z == within(wo.z, 0.2));
  }
}

template <template <class> class Bsdf> void check_glass() {
  struct Surface {
    float eta, u, v;
  };
  for (const Surface s :
       {Surface{1.5f, 0.2f, 0.2f}, Surface{1.5f, 0.3f, 0.8f}, Surface{1 / 1.5f, 0.3f, 0.3f}, Surface{2.4f, 1, 1}}) {
    CAPTURE(s.eta);
    CAPTURE(s.u);
    const auto bsdf = glass<Bsdf>(s.eta, s.u, s.v, 0.75f, 0.5f);
    check_bsdf_sampling_with_edges(bsdf, kSamplingTests);
    check_bsdf_weights(bsdf, 5e-4);
    check_bsdf_reciprocity(bsdf, 1 / s.eta);  // f over the squared index of wo's side is symmetric (Veach 1997, 5.2)
  }
  for (const float eta : {1.5f, 1 / 1.5f, 1.0f})
    for (const float alpha : {0.01f, 0.3f, 1.0f}) {
      check_white_furnace(glass<Bsdf>(eta, alpha, alpha), false);
      check_bsdf_finite(glass<Bsdf>(eta, alpha, alpha));
    }
}

/// For small roughness the samples converge to those of DielectricBsdf.
template <template <class> class Bsdf> void check_smooth_limit() {
  for (const float cosine : {0.9f, 0.3f, -0.9f, -0.5f})
    for (const float u : {0.0f, 0.999999f}) {
      const Vec3f wo = direction_of(cosine, 0.8);
      const auto fresnel = fresnel_dielectric<Scalar>(wo.z, 1.5f);
      const auto s = glass<Bsdf>(1.5f, 1e-4f, 1e-4f, 0.75f, 0.5f).sample(wo, {u, 0.5f, 0.5f, 0});
      const bool reflected = u < fresnel.reflectance;
      REQUIRE(s.valid);
      CHECK(s.wi.z == near(reflected ? wo.z : fresnel.cos_transmitted, 1e-3));
      CHECK(s.wi.x == near(reflected ? -wo.x : -wo.x / fresnel.eta, 1e-3));
      CHECK(s.eta_scale == near(reflected ? 1 : fresnel.eta * fresnel.eta));
      CHECK(s.weight.c0 == near(reflected ? 0.75 : 0.5 / (fresnel.eta * fresnel.eta), 1e-3));
    }
}

}  // namespace

TEST_SUITE_BEGIN("slow");

TEST_CASE("rough conductor: samples have consistent weights and values are reciprocal without energy gain") {
  check_metal<RoughConductorGgxBsdf>();
  check_metal<RoughConductorBeckmannBsdf>();
}

TEST_CASE("rough conductor: the inside scatters nothing") {
  const auto bsdf = metal<RoughConductorGgxBsdf>(0.3f, 0.3f);
  CHECK(is_black(bsdf.evaluate({0, 0.6f, -0.8f}, {0, 0, -1}).f_cos));
  CHECK(is_black(bsdf.evaluate({0, 0.6f, 0.8f}, {0, 0, -1}).f_cos));
  CHECK_FALSE(bsdf.sample({0, 0.6f, -0.8f}, {0.5f, 0.5f, 0.5f, 0}).valid);
}

TEST_CASE("rough dielectric: samples have consistent weights and values are reciprocal from both sides") {
  check_glass<RoughDielectricGgxBsdf>();
  check_glass<RoughDielectricBeckmannBsdf>();
}

TEST_CASE("rough dielectric: vanishing roughness gives the smooth dielectric") {
  check_smooth_limit<RoughDielectricGgxBsdf>();
  check_smooth_limit<RoughDielectricBeckmannBsdf>();
}

TEST_CASE("thin dielectric: light that is not reflected passes straight and all orders of reflection count") {
  for (const Vec3f wo : outgoing_directions()) {
    const double once = fresnel_dielectric<Scalar>(std::fabs(wo.z), 1.5f).reflectance;
    int reflected = 0;
    constexpr int kDraws = 20000;
    for (std::uint32_t i = 0; i < kDraws; ++i) {
      const auto s = pane(1.5f, 0.75f, 0.5f).sample(wo, lane_random(42, i, 0));
      REQUIRE(s.valid);
      const bool mirrored = s.wi.z * wo.z > 0;
      reflected += mirrored;
      CHECK(s.wi == Vec3f{-wo.x, -wo.y, mirrored ? wo.z : -wo.z});
      CHECK(s.weight.c1 == (mirrored ? 0.75f : 0.5f));
      CHECK(s.eta_scale == 1.0f);
      CHECK(s.pdf_solid_angle == 0.0f);
    }
    // R + T R T + T R^3 T + ...
    double fraction = once;
    for (int order = 1; order < 4000; order += 2) fraction += (1 - once) * (1 - once) * std::pow(once, order);
    const double threshold = student_t_threshold(significance_of_each(10), kDraws - 1);
    CHECK(std::fabs(reflected - kDraws * fraction) <= threshold * std::sqrt(kDraws * fraction * (1 - fraction)) + 1);
  }
  check_white_furnace(pane(1.5f), true);
  check_white_furnace(pane(1 / 1.5f), true);
  CHECK(is_black(pane(1.5f).evaluate({0, 0, 1}, {0, 0, -1}).f_cos));
}

TEST_CASE("nori microfacet: samples have consistent weights and values are reciprocal without energy gain") {
  for (const auto& [kd, alpha] :
       {std::pair{0.5f, 0.15f}, std::pair{0.2f, 0.6f}, std::pair{0.0f, 0.3f}, std::pair{1.0f, 0.3f}}) {
    CAPTURE_BINDING(kd);
    check_bsdf_sampling_with_edges(nori(kd, alpha), kSamplingTests);
    check_bsdf_weights(nori(kd, alpha));
    check_bsdf_reciprocity(nori(kd, alpha));
    check_white_furnace(nori(kd, alpha), false);
    check_bsdf_finite(nori(kd, alpha));
  }
  // Normal incidence on facets that all face up: kd / pi + ks F / (4 pi alpha^2).
  const double expected = 0.5 / 3.14159265358979 + 0.5 * 0.04 / (4 * 3.14159265358979 * 0.01);
  CHECK(nori(0.5f, 0.1f).evaluate({0, 0, 1}, {0, 0, 1}).f_cos.c0 == near(expected, 1e-5));
  CHECK(is_black(nori(0.5f, 0.1f).evaluate({0, 0, -1}, {0, 0, 1}).f_cos));
}

TEST_CASE("nori microfacet: shadowing follows the approximation of Walter et al.") {
  constexpr double kPi = 3.14159265358979;
  for (const double theta : {0.3, 0.9, 1.05, 1.3, 1.5})
    for (const double alpha : {0.4, 0.6}) {
      const double cosine = std::cos(theta), b = 1 / (alpha * std::tan(theta));
      const double g1 = b < 1.6 ? (3.535 * b + 2.181 * b * b) / (1 + 2.276 * b + 2.577 * b * b) : 1;
      const Vec3f wo{static_cast<float>(std::sin(theta)), 0, static_cast<float>(cosine)};
      const double fresnel = static_cast<double>(fresnel_dielectric<Scalar>(wo.z, 1.5f).reflectance);
      // The distribution at its peak is 1 / (pi alpha^2).
      const double expected = fresnel * g1 * g1 / (4 * kPi * alpha * alpha * cosine);
      const float found = nori(0, static_cast<float>(alpha)).evaluate(wo, {-wo.x, 0, wo.z}).f_cos.c0;
      CAPTURE(theta);
      CAPTURE(alpha);
      CHECK(static_cast<double>(found) == near(expected, 1e-4));
    }
}

TEST_CASE("rough bsdfs: SIMD results equal scalar ones") {
  const auto fraction = [](int lane, int k) {
    return static_cast<float>(lane + 1 + k) / static_cast<float>(kWidth + 4);
  };
  const auto alpha = [&](int lane) { return 0.15f + 0.8f * fraction(lane, 1); };
  check_bsdf_lanes<RoughConductorGgxBsdf>([&](int l) { return metal<RoughConductorGgxBsdf>(alpha(l), 0.5f); });
  check_bsdf_lanes<RoughConductorBeckmannBsdf>(
      [&](int l) { return metal<RoughConductorBeckmannBsdf>(alpha(l), 0.5f); });
  // No index close to 1: half vectors of nearly opposite directions consist of rounding errors.
  const auto eta = [&](int lane) {
    return fraction(lane, 1) < 0.5f ? 0.45f + fraction(lane, 1) * 0.9f : 0.6f + fraction(lane, 1);
  };
  check_bsdf_lanes<RoughDielectricGgxBsdf>(
      [&](int l) { return glass<RoughDielectricGgxBsdf>(eta(l), alpha(l), 0.5f); });
  check_bsdf_lanes<RoughDielectricBeckmannBsdf>(
      [&](int l) { return glass<RoughDielectricBeckmannBsdf>(1.2f + fraction(l, 1), alpha(l), 0.5f); });
  check_bsdf_lanes<ThinDielectricBsdf>([&](int l) { return pane(1.2f + fraction(l, 1), fraction(l, 2), 0.9f); });
  check_bsdf_lanes<NoriMicrofacetBsdf>([&](int l) { return nori(fraction(l, 2), alpha(l)); });
}

TEST_SUITE_END();

}  // namespace sheaf::test_bsdf_rough
