// Tests that apply to every BSDF in the list. Tests of individual BSDFs are in test_bsdf*.cpp and test_phase.cpp.
#include "tests/support/any_bsdf.h"
#include "tests/support/bsdf_testing.h"
#include "tests/support/near.h"

#include <set>
#include <string_view>

namespace sheaf::test_bsdf_list {

namespace {

constexpr std::uint32_t kVariants = 1;  ///< parameter sets per BSDF
constexpr int kTests = 10 * kVariants * kClosureKinds;

/// A BSDF without its delta lobes: their samples count as absorbed.
template <class Bsdf> struct WithoutDeltas {
  Bsdf bsdf;

  BsdfValue<Scalar> evaluate(Vec3f wo, Vec3f wi) const { return bsdf.evaluate(wo, wi); }
  BsdfSample<Scalar> sample(Vec3f wo, const Random4<Scalar>& u) const {
    BsdfSample<Scalar> s = bsdf.sample(wo, u);
    s.valid = s.valid && s.pdf_solid_angle > 0.0f;
    return s;
  }
};

template <class F> void for_each_variant(F&& f) {
  for_each_bsdf([&]<template <class> class Bsdf>(ClosureKind kind, BsdfTag<Bsdf>) {
    for (std::uint32_t i = 0; i < kVariants; ++i) {
      CAPTURE(closure_info(kind).name);
      CAPTURE(i);
      f(any_bsdf<Bsdf>(i));
    }
  });
}

}  // namespace

TEST_SUITE_BEGIN("slow");

TEST_CASE("all bsdfs: samples have consistent pdfs and weights") {
  for_each_variant([]<class Bsdf>(const Bsdf& bsdf) {
    if constexpr (!Bsdf::kIsSpecular) {
      // Tabulated BSDFs have edges everywhere, but shallow ones. Near the normal their pdfs are steep.
      constexpr bool kTables = kHasTables<Bsdf>;
      check_bsdf_sampling_with_edges(WithoutDeltas<Bsdf>{bsdf}, kTests, kTables ? 2 : 6);
      check_bsdf_weights(WithoutDeltas<Bsdf>{bsdf}, kTables ? 1e-2 : 2e-3);
    }
  });
}

TEST_CASE("all bsdfs: values are finite for all directions") {
  for_each_variant([](const auto& bsdf) { check_bsdf_finite(bsdf); });
}

TEST_CASE("all bsdfs: samples use the declared random numbers only") {
  for_each_variant([]<class Bsdf>(const Bsdf& bsdf) {
    constexpr unsigned kUsed = numbers_of<Bsdf>();
    const BsdfView view(bsdf);
    int wrong = 0;
    for (std::uint32_t i = 0; i < 200; ++i) {
      const Vec3f wo = random_direction(15, i);
      const auto u = lane_random(16, i, 0), other = lane_random(17, i, 0);
      const Random4<Scalar> changed{(kUsed & kNumberX) != 0 ? u.x : other.x, (kUsed & kNumberY) != 0 ? u.y : other.y,
                                    (kUsed & kNumberZ) != 0 ? u.z : other.z, other.w};
      const auto a = view.sample(wo, u), b = view.sample(wo, changed);
      wrong += a.valid != b.valid || a.eta_scale != b.eta_scale || a.pdf_solid_angle != b.pdf_solid_angle;
      if (!a.valid) continue;
      wrong += a.wi.x != b.wi.x || a.wi.y != b.wi.y || a.wi.z != b.wi.z;
      wrong += a.weight.c0 != b.weight.c0 || a.weight.c1 != b.weight.c1 || a.weight.c2 != b.weight.c2;
    }
    CHECK(wrong == 0);
  });
}

TEST_CASE("all bsdfs: specular BSDFs have no pdf") {
  for_each_variant([]<class Bsdf>(const Bsdf& bsdf) {
    if constexpr (Bsdf::kIsSpecular)
      for (std::uint32_t i = 0; i < 100; ++i) {
        const Vec3f wo = random_direction(11, i), wi = random_direction(12, i);
        const auto [f, pdf] = bsdf.evaluate(wo, wi);
        CHECK(pdf == 0.0f);
        CHECK(is_black(f));
        CHECK(bsdf.sample(wo, lane_random(13, i, 0)).pdf_solid_angle == 0.0f);
      }
  });
}

TEST_CASE("all bsdfs: the pass-through of thin dielectrics agrees with their samples") {
  for_each_variant([]<class Bsdf>(const Bsdf& bsdf) {
    if constexpr (Bsdf::Closure::kInfo.is_thin_dielectric)
      for (const Vec3f wo : outgoing_directions()) {
        constexpr std::uint32_t kDraws = 20000;
        const StraightTransmission<Scalar> passage = bsdf.passage(wo.z);
        double passed = 0, light = 0;
        for (std::uint32_t i = 0; i < kDraws; ++i) {
          const auto s = bsdf.sample(wo, lane_random(14, i, 0));
          if (!s.valid || s.wi.z * wo.z > 0) continue;
          CHECK(length(s.wi + wo) < 1e-6f);
          ++passed;
          light += double(s.weight.c1);
        }
        const double p = double(passage.probability), sigma = std::sqrt(p * (1 - p) / kDraws);
        const double threshold = student_t_threshold(significance_of_each(kTests), kDraws - 1);
        CHECK(std::fabs(passed / kDraws - p) <= threshold * sigma + 1.0 / kDraws);
        // Every ray that passes has the same weight.
        CHECK(light / std::max(passed, 1.0) * p == near(double(passage.attenuation.c1), 1e-4));
      }
  });
}

TEST_CASE("all bsdfs: SIMD results equal scalar ones") {
  for_each_bsdf([]<template <class> class Bsdf>(ClosureKind kind, BsdfTag<Bsdf>) {
    CAPTURE(closure_info(kind).name);
    check_bsdf_lanes<Bsdf>([](int lane) { return any_bsdf<Bsdf>(static_cast<std::uint32_t>(lane)); });
  });
}

TEST_CASE("all bsdfs: each kind has a distinct name") {
  std::set<std::string_view> names;
  for (const ClosureInfo& info : kClosureInfos) names.insert(info.name);
  CHECK(names.size() == kClosureInfos.size());
  CHECK(closure_info(kClosureKind<ThinDielectricClosure>).is_thin_dielectric);
  CHECK_FALSE(closure_info(kClosureKind<DielectricClosure>).is_thin_dielectric);
  CHECK(closure_info(kClosureKind<RayleighClosure>).is_phase);
}

TEST_SUITE_END();

}  // namespace sheaf::test_bsdf_list
