// Coats over other closures: sampling, energy, and comparisons with plastics and closed forms.
#include "kernels/bsdf/rough_coated.h"
#include "scene/materials/rough_coat.h"

#include "tests/support/any_bsdf.h"
#include "tests/support/bsdf_testing.h"
#include "tests/support/near.h"

namespace sheaf::test_bsdf_coated {

namespace {

using Distribution = RoughnessDescription::Distribution;
constexpr double kPiD = 3.14159265358979323846;
constexpr int kSamplingTests = 5;

void set_coat(CoatedParameters<Scalar>& coat, float eta, float absorption) {
  coat.coat_eta = eta;
  coat.coat_thickness = 0.5f;
  coat.coat_absorption = {absorption, 2 * absorption, 0, 0};
  coat.coat_specular = {1, 1, 1, 0};
  for (Spectrum4& s : coat.nested_spectra) s = Spectrum4(0.0f);
  for (float& x : coat.nested_numbers) x = 0;
}

template <template <class> class Nested>
CoatedBsdf<Scalar> coated(const Nested<Scalar>& nested, float eta, float absorption) {
  CoatedBsdf<Scalar> bsdf;
  set_coat(bsdf, eta, absorption);
  set_nested(bsdf, nested);
  return bsdf;
}

template <template <class> class Nested>
RoughCoatedGgxBsdf<Scalar> rough_coated(const Nested<Scalar>& nested, float eta, float absorption, float alpha) {
  RoughCoatedGgxBsdf<Scalar> bsdf;
  set_coat(bsdf, eta, absorption);
  set_nested(bsdf, nested);
  bsdf.coat_alpha = alpha;
  const RoughCoat coat = rough_coat(Distribution::kGgx, alpha, eta);
  std::copy(coat.transmittance.begin(), coat.transmittance.end(), bsdf.transmittance);
  return bsdf;
}

DiffuseBsdf<Scalar> diffuse(float reflectance) {
  DiffuseBsdf<Scalar> bsdf;
  bsdf.reflectance = {reflectance, 0.5f * reflectance, 0.2f * reflectance, 0};
  return bsdf;
}

ConductorBsdf<Scalar> mirror(float reflectance) {
  ConductorBsdf<Scalar> bsdf;
  bsdf.eta = Spectrum4(0.0f);
  bsdf.k = Spectrum4(1.0f);
  bsdf.reflectance = {reflectance, reflectance, reflectance, 0};
  return bsdf;
}

/// A coated BSDF without its delta lobes: their samples count as absorbed.
struct WithoutMirror : CoatedBsdf<Scalar> {
  BsdfSample<Scalar> sample(Vec3f wo, const Random4<Scalar>& u) const {
    auto s = CoatedBsdf<Scalar>::sample(wo, u);
    s.valid = s.valid && s.pdf_solid_angle > 0;
    return s;
  }
};

}  // namespace

TEST_SUITE_BEGIN("slow");

TEST_CASE("coats: samples of every closure have consistent pdfs and weights") {
  for_each_coatable_bsdf([]<template <class> class Nested>(ClosureKind, BsdfTag<Nested>) {
    CAPTURE(Nested<Scalar>::Closure::kInfo.name);
    const auto nested = any_bsdf<Nested>(3);
    WithoutMirror smooth;
    static_cast<CoatedBsdf<Scalar>&>(smooth) = coated(nested, 1.5f, 0.3f);
    check_bsdf_weights(smooth, 2e-3);
    check_bsdf_finite(smooth);
  });
}

TEST_CASE("coats: samples over an anisotropic lobe follow their pdf") {
  check_bsdf_sampling_with_edges(rough_coated(any_bsdf<WardBsdf>(2), 1.4f, 0.1f, 0.3f), kSamplingTests);
  check_bsdf_weights(rough_coated(any_bsdf<WardBsdf>(2), 1.4f, 0.1f, 0.3f), 2e-3);
}

TEST_CASE("coats: coated closures are reciprocal and do not gain energy") {
  check_bsdf_reciprocity(coated(diffuse(0.7f), 1.5f, 0.4f));
  check_bsdf_reciprocity(rough_coated(diffuse(0.7f), 1.5f, 0.4f, 0.3f));
  for (const float eta : {1.1f, 1.5f, 2.4f}) {
    CAPTURE(eta);
    check_white_furnace(coated(diffuse(1), eta, 0), false);
    check_white_furnace(coated(mirror(1), eta, 0), false);
    check_white_furnace(rough_coated(diffuse(1), eta, 0, 0.3f), false);
    check_white_furnace(rough_coated(mirror(1), eta, 0, 0.3f), false);
  }
  // A coat without a boundary and without absorption has no effect.
  check_white_furnace(coated(diffuse(1), 1, 0), true);
}

TEST_CASE("coats: a coated diffuse closure is a plastic without internal reflection") {
  PlasticBsdf<Scalar> plastic;
  plastic.eta = 1.5f;
  plastic.diffuse = {0.6f, 0.3f, 0.12f, 0};
  plastic.specular = {1, 1, 1, 0};
  plastic.nonlinear = 0;
  plastic.internal_reflectance = 0;
  const auto bsdf = coated(diffuse(0.6f), 1.5f, 0);
  for (std::uint32_t i = 0; i < 200; ++i) {
    const Vec3f wo = random_direction(71, i), wi = random_direction(72, i);
    CHECK(bsdf.evaluate(wo, wi).f_cos.c1 == near(plastic.evaluate(wo, wi).f_cos.c1, 1e-4));
  }
}

TEST_CASE("coats: values match computations by hand") {
  // Both directions are at 30 degrees. Inside the coat the cosine is sqrt(1 - 1/9).
  const double cosine = std::sqrt(0.75), within = std::sqrt(1 - 0.25 / 2.25), eta = 1.5;
  const double s = (cosine - eta * within) / (cosine + eta * within),
               p = (within - eta * cosine) / (within + eta * cosine);
  const double r = 0.5 * (s * s + p * p), dim = std::exp(-0.4 * 0.5 * 2 / within);
  const Vec3f wo = direction_of(cosine, 0), wi = direction_of(cosine, 1);
  CHECK(coated(diffuse(0.6f), 1.5f, 0.4f).evaluate(wo, wi).f_cos.c0 ==
        near((1 - r) * (1 - r) * dim * 0.6 / kPiD * cosine / (eta * eta), 1e-4));
  // A mirror under a coat has two delta reflections.
  MeanVariance energy;
  for (std::uint32_t i = 0; i < 20000; ++i) {
    const auto one = coated(mirror(0.8f), 1.5f, 0.4f).sample(wo, lane_random(73, i, 0));
    REQUIRE(one.valid);
    CHECK(one.pdf_solid_angle == 0.0f);
    CHECK(length(one.wi - Vec3f{-wo.x, -wo.y, wo.z}) < 1e-5f);
    energy.add(double(one.weight.c0));
  }
  const double expected = r + (1 - r) * (1 - r) * 0.8 * dim;
  CHECK(std::fabs(energy.mean() - expected) < 1e-4 + 5 * std::sqrt(energy.variance() / 20000));
}

TEST_CASE("coats: a nearly smooth rough coat approximates a smooth one") {
  const auto smooth = coated(diffuse(0.6f), 1.5f, 0.4f);
  const auto rough = rough_coated(diffuse(0.6f), 1.5f, 0.4f, 1e-4f);
  for (std::uint32_t i = 0; i < 200; ++i) {
    const Vec3f wo = random_direction(74, i), wi = random_direction(75, i);
    CHECK(rough.evaluate(wo, wi).f_cos.c0 == near(smooth.evaluate(wo, wi).f_cos.c0, 0.01));
  }
}

TEST_CASE("coats: SIMD results of mixed closures equal scalar ones") {
  check_bsdf_lanes<CoatedBsdf>([](int lane) {
    CoatedBsdf<Scalar> out;
    int left = lane % 13;
    for_each_coatable_bsdf([&]<template <class> class Nested>(ClosureKind, BsdfTag<Nested>) {
      if (left-- == 0) out = coated(any_bsdf<Nested>(static_cast<std::uint32_t>(lane)), 1.4f, 0.2f);
    });
    return out;
  });
}

TEST_SUITE_END();

}  // namespace sheaf::test_bsdf_coated
