// Spectral upsampling: round trips from colors, grays, the boundary of the gamut and invalid input.
#include "core/color/uplift.h"

#include "core/sampling/rng.h"
#include "tests/support/lanes_testing.h"
#include "tests/support/near.h"
#include "tests/support/spectral_testing.h"

#include <doctest/doctest.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

namespace sheaf::test_uplift {

namespace {

Vec3f color_of(const ScaledSigmoid<Scalar>& s) {
  return reflectance_to_rgb([&](float wavelength) { return s.scale * evaluate(s.shape, wavelength); });
}

/// Calls f for the colors of a 32^3 grid in sRGB encoding, with every `step`-th value per axis.
template <class F> void for_each_color(int step, F&& f) {
  constexpr int kSteps = 32;
  for (int r = 0; r < kSteps; r += step)
    for (int g = 0; g < kSteps; g += step)
      for (int b = 0; b < kSteps; b += step)
        f(srgb_to_linear(Vec3f{static_cast<float>(r), static_cast<float>(g), static_cast<float>(b)} / (kSteps - 1.0f)));
}

Vec3f random_color(std::uint32_t i) {
  const auto u = random4<Scalar>(5, i, 0, 0);
  return {u.x, u.y, u.z};
}

}  // namespace

TEST_CASE("sigmoid: limits and symmetry and inverse hold") {
  CHECK(sigmoid(0.0f) == 0.5f);
  CHECK(sigmoid(kInfinity) == 1.0f);
  CHECK(sigmoid(-kInfinity) == 0.0f);
  CHECK(sigmoid(1e15f) == 1.0f);
  for (const double x : {-300.0, -3.0, -0.1, 0.4, 7.0, 100.0}) {
    CHECK(static_cast<double>(sigmoid(static_cast<float>(x))) == near(0.5 + x / (2 * std::sqrt(1 + x * x)), 2e-5));
    CHECK(sigmoid(static_cast<float>(x)) + sigmoid(static_cast<float>(-x)) == near(1));
  }
  for (float v = 0.01f; v < 1; v += 0.07f) CHECK(sigmoid(inverse_sigmoid(v)) == near(v));
  CHECK(sigmoid(inverse_sigmoid(1.0f)) == 1.0f);
  CHECK(sigmoid(inverse_sigmoid(0.0f)) == 0.0f);
}

TEST_CASE("uplift: spectra from the table restore their colors") {
  float worst = 0;
  Vec3f worst_at;
  for_each_color(1, [&](Vec3f rgb) {
    const float error = largest_difference(color_of(uplift_reflectance<Scalar>(UpliftTable::get(), rgb)), rgb);
    if (error > worst) worst = error, worst_at = rgb;
  });
  MESSAGE("largest error per component " << worst << " at " << worst_at.x << " " << worst_at.y << " " << worst_at.z);
  CHECK(worst < 0.005f);
}

TEST_CASE("uplift: individually fitted spectra restore their colors") {
  float worst = 0;
  const auto check = [&](Vec3f rgb) {
    worst = std::max(worst, largest_difference(color_of(fit_reflectance(rgb)), rgb));
  };
  for_each_color(5, check);
  for (const Vec3f rgb : {Vec3f{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 0}, {0, 1, 1}, {1, 0, 1}, {1, 1, 0.999f}})
    check(rgb);
  MESSAGE("largest error per component " << worst);
  CHECK(worst < 2e-4f);
}

TEST_CASE("uplift: the spectra match those of other implementations of the sigmoid model") {
  // Mitsuba 3.9.1 (variant scalar_spectral) at 400, 500, 560 and 700 nm. Its white is 0.1 % off.
  const std::pair<Vec3f, std::array<double, 4>> cases[] = {
      {{0.8f, 0.1f, 0.2f}, {0.733398, 0.0947943, 0.155087, 0.988831}},
      {{0.1f, 0.6f, 0.15f}, {0.0266907, 0.502919, 0.559167, 0.012245}},
      {{0.5f, 0.5f, 0.2f}, {0.0944729, 0.389895, 0.518248, 0.237194}}};
  for (const auto& [rgb, expected] : cases)
    for (const auto& s : {fit_reflectance(rgb), uplift_reflectance<Scalar>(UpliftTable::get(), rgb)}) {
      const Spectrum4 v = evaluate(s, Spectrum4(400, 500, 560, 700));
      const std::array<float, 4> found{v.c0, v.c1, v.c2, v.c3};
      for (std::size_t k = 0; k < 4; ++k) CHECK(std::abs(static_cast<double>(found[k]) - expected[k]) < 1e-3);
    }
}

TEST_CASE("uplift: the error between grid points is proportional to the brightness") {
  float worst = 0, worst_unbounded = 0;
  for (std::uint32_t i = 0; i < 3000; ++i) {
    const Vec3f rgb = random_color(i) * (i % 2 == 0 ? 1.0f : 0.02f);
    const float per = 1.0f / max_component(rgb);
    const auto reflects = uplift_reflectance<Scalar>(UpliftTable::get(), rgb);
    worst = std::max(worst, per * largest_difference(color_of(reflects), rgb));
    const Vec3f bright = rgb * 1000.0f;
    const auto emits = uplift_unbounded<Scalar>(UpliftTable::get(), bright);
    worst_unbounded = std::max(worst_unbounded, per * largest_difference(color_of(emits), bright) / 1000);
  }
  CHECK(worst < 0.01f);
  CHECK(worst_unbounded < 0.005f);
}

TEST_CASE("uplift: grays have exactly constant spectra") {
  const Spectrum4 lambda(360, 480.5f, 617.25f, 830);
  for (const float gray : {0.0f, 1e-6f, 0.1f, 0.25f, 0.5f, 0.73f, 1.0f}) {
    for (const auto& s : {uplift_reflectance<Scalar>(UpliftTable::get(), Vec3f{gray, gray, gray}),
                          fit_reflectance({gray, gray, gray})}) {
      const Spectrum4 v = evaluate(s, lambda);
      CHECK((v.c0 == gray && v.c1 == gray && v.c2 == gray && v.c3 == gray));
    }
    const float large = 1000 * gray;
    for (const auto& s : {uplift_unbounded<Scalar>(UpliftTable::get(), Vec3f{large, large, large}),
                          fit_unbounded({large, large, large})}) {
      const Spectrum4 v = evaluate(s, lambda);
      CHECK((v.c0 == large && v.c1 == large && v.c2 == large && v.c3 == large));
    }
    // Like colored values: a shape of fixed brightness and a scale.
    const auto unbounded = uplift_unbounded<Scalar>(UpliftTable::get(), Vec3f{large, large, large});
    CHECK(evaluate(unbounded.shape, 500.0f) == kUpliftUnbounded);
    CHECK(unbounded.scale == 2 * large);
  }
}

TEST_CASE("uplift: reflectances stay between 0 and 1 for any input") {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  std::vector<Vec3f> colors{{1, 1, 1},           {1, 0, 0},          {0, 1, 1},          {0, 0, 0},
                            {2, 3, -1},          {kNan, 0.5f, 0.2f}, {kNan, kNan, kNan}, {kInfinity, 1, 0},
                            {1e-30f, 0, 1e-38f}, {1e-42f, 0, 0},     {-1, -2, -3},       {1, 1, 0.9999999f}};
  for (std::uint32_t i = 0; i < 500; ++i) colors.push_back(random_color(i));
  for (const Vec3f rgb : colors) {
    CAPTURE(rgb.x);
    CAPTURE(rgb.y);
    CAPTURE(rgb.z);
    for (const auto& s : {uplift_reflectance<Scalar>(UpliftTable::get(), rgb), fit_reflectance(rgb)})
      for (float lambda = 360; lambda <= 830; lambda += 10) {
        const float v = s.scale * evaluate(s.shape, lambda);
        REQUIRE((v >= 0.0f && v <= 1.0f));
      }
  }
  const auto dark = uplift_unbounded<Scalar>(UpliftTable::get(), Vec3f{-1, kNan, 0});
  CHECK(dark.scale * evaluate(dark.shape, 500.0f) == 0.0f);
}

TEST_CASE("uplift: the table does not depend on the number of threads or on the caller") {
  const UpliftTable& table = UpliftTable::get();
  tbb::task_arena(1).execute([&] { CHECK(UpliftTable().nodes == table.nodes); });
  std::atomic<int> equal{0};
  tbb::parallel_for(0, 8, [&](int) { equal += UpliftTable().nodes == UpliftTable::get().nodes ? 1 : 0; });
  CHECK(equal == 8);
}

TEST_CASE("uplift: an unbounded color's spectrum is proportional to it") {
  const Vec3f rgb{0.2f, 3.0f, 1.7f};
  for (float lambda = 365; lambda < 830; lambda += 55) {
    const auto one = fit_unbounded(rgb), ten = fit_unbounded(rgb * 10.0f);
    CHECK(ten.scale * evaluate(ten.shape, lambda) ==
          near(static_cast<double>(10 * one.scale * evaluate(one.shape, lambda)), 1e-3));
  }
  CHECK(largest_difference(color_of(fit_unbounded(rgb)), rgb) < 1e-3f);
}

TEST_CASE("uplift: SIMD results equal scalar ones") {
  for (std::uint32_t i = 0; i < 64; ++i) {
    const auto color = [&](int lane) { return random_color(i * 16 + static_cast<std::uint32_t>(lane)); };
    const Vec3<Wide> rgb{wide_floats([&](int lane) { return color(lane).x; }),
                         wide_floats([&](int lane) { return lane % 3 == 0 ? color(lane).x : color(lane).y; }),
                         wide_floats([&](int lane) { return lane % 6 == 0 ? color(lane).x : color(lane).z; })};
    const auto wide = uplift_reflectance<Wide>(UpliftTable::get(), rgb);
    const auto bright = uplift_unbounded<Wide>(UpliftTable::get(), rgb);
    const Spectrum<Wide> lambda(WideFloat(450), WideFloat(530), WideFloat(610), WideFloat(700));
    const Spectrum<Wide> at = evaluate(wide, lambda);
    for (int lane = 0; lane < kWidth; ++lane) {
      const Vec3f one{rgb.x[lane], rgb.y[lane], rgb.z[lane]};
      const auto s = uplift_reflectance<Scalar>(UpliftTable::get(), one);
      CHECK(difference(wide.scale[lane], s.scale) < 1e-6);
      CHECK(difference(wide.shape.c1[lane], s.shape.c1) < 1e-5);
      CHECK(difference(at.c1[lane], evaluate(s, Spectrum4(450, 530, 610, 700)).c1) < 1e-5);
      CHECK(difference(bright.shape.c0[lane], uplift_unbounded<Scalar>(UpliftTable::get(), one).shape.c0) < 1e-5);
    }
  }
}

}  // namespace sheaf::test_uplift
