// Pixel filters: their formulas, and sampled filters against integrals of the formulas.
#include "scene/tables/filter.h"

#include "tests/support/chi_square.h"
#include "tests/support/lanes_testing.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

namespace sheaf::test_filter {

namespace {

using Kind = PixelFilter::Kind;

PixelFilter filter(Kind kind) {
  PixelFilter f;
  f.kind = kind;
  return f;
}

/// Every kind of filter, parametric ones with several settings.
std::vector<PixelFilter> all_filters() {
  std::vector<PixelFilter> out = {filter(Kind::kBox),      filter(Kind::kTent),       filter(Kind::kGaussian),
                                  filter(Kind::kMitchell), filter(Kind::kCatmullRom), filter(Kind::kLanczos)};
  PixelFilter f = filter(Kind::kTent);
  f.radius = 2.5f;
  out.push_back(f);
  f = filter(Kind::kGaussian);
  f.stddev = 1.25f;
  out.push_back(f);
  f = filter(Kind::kMitchell);
  f.b = 0.1f;
  f.c = 0.7f;
  out.push_back(f);
  f = filter(Kind::kLanczos);
  f.lobes = 2;
  out.push_back(f);
  return out;
}

/// Midpoint rule over the support of the filter.
double integral(const PixelFilter& f, const std::function<double(double)>& g) {
  constexpr int kSteps = 20000;
  const double radius = filter_radius(f), step = 2 * radius / kSteps;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double x = -radius + (i + 0.5) * step;
    sum += g(x) * step;
  }
  return sum;
}

}  // namespace

TEST_CASE("filter: values match the closed forms at selected points") {
  CHECK(evaluate_filter(filter(Kind::kBox), 0.49) == 1.0);
  CHECK(evaluate_filter(filter(Kind::kBox), 0.51) == 0.0);
  CHECK(evaluate_filter(filter(Kind::kTent), 0.25) == near(0.5));
  CHECK(evaluate_filter(filter(Kind::kGaussian), 2.0) == within(0, 1e-7));
  CHECK(evaluate_filter(filter(Kind::kGaussian), 0.5) / evaluate_filter(filter(Kind::kGaussian), 0) ==
        near((std::exp(-0.5) - std::exp(-8)) / (1 - std::exp(-8))));
  CHECK(evaluate_filter(filter(Kind::kMitchell), 0) == near(8.0 / 9));
  CHECK(evaluate_filter(filter(Kind::kMitchell), -1) == near(1.0 / 18));
  CHECK(evaluate_filter(filter(Kind::kCatmullRom), 1.5) == near(-0.0625));
  CHECK(evaluate_filter(filter(Kind::kLanczos), 0.5) ==
        near(std::sin(kPi / 2) / (kPi / 2) * std::sin(kPi / 6) / (kPi / 6)));
  for (const double x : {1.0, 2.0}) {
    CHECK(evaluate_filter(filter(Kind::kCatmullRom), x) == within(0, 1e-6));
    CHECK(evaluate_filter(filter(Kind::kLanczos), x) == within(0, 1e-6));
  }
  CHECK(filter_radius(filter(Kind::kGaussian)) == 2.0);
  CHECK(filter_radius(filter(Kind::kMitchell)) == 2.0);
  CHECK(filter_radius(filter(Kind::kLanczos)) == 3.0);
}

TEST_CASE("filter: cubic filters of unit spacing sum to one") {
  for (const PixelFilter& f : all_filters()) {
    if (f.kind != Kind::kMitchell && f.kind != Kind::kCatmullRom) continue;
    for (const double x : {0.0, 0.13, 0.5, 0.87}) {
      double sum = 0;
      for (int i = -3; i <= 3; ++i) sum += evaluate_filter(f, x + i);
      CHECK(sum == near(1));
    }
  }
}

TEST_CASE("filter: all filters are even and vanish at their radius") {
  for (const PixelFilter& f : all_filters()) {
    const double radius = filter_radius(f);
    for (int i = 0; i <= 50; ++i) {
      const double x = radius * i / 50;
      CHECK(evaluate_filter(f, x) == evaluate_filter(f, -x));
    }
    CHECK(evaluate_filter(f, radius * 1.0001) == 0.0);
  }
}

TEST_CASE("filter: weights in other pixels equal the filter within its radius") {
  for (const PixelFilter& f : all_filters()) {
    CAPTURE(static_cast<int>(f.kind));
    const FilterWeights weights(f);
    const double radius = filter_radius(f);
    std::array<double, FilterWeights::kMaxPixels> across{};
    for (int i = -200; i <= 200; ++i) {
      const double offset = i / 400.0;
      weights.across(static_cast<float>(offset), across.data());
      for (int k = -weights.reach(); k <= weights.reach(); ++k) {
        CAPTURE(offset);
        CAPTURE(k);
        const double x = k - offset;
        // At the edge of the support, the last bit of the offset decides.
        if (std::fabs(std::fabs(x) - radius) < 1e-6) continue;
        const double weight = across[static_cast<std::size_t>(k + weights.reach())];
        CHECK(std::fabs(weight - evaluate_filter(f, x) / evaluate_filter(f, 0)) < 1e-5);
        if (std::fabs(x) > radius) CHECK(weight == 0.0);
      }
    }
    // The reach is the farthest pixel that a sample can contribute to, and no more.
    CHECK(weights.reach() - 0.5 < radius);
    CHECK(weights.reach() + 0.5 >= radius);
  }
  CHECK(FilterWeights(filter(Kind::kBox)).reach() == 0);
  CHECK(FilterWeights(filter(Kind::kGaussian)).reach() == 2);
}

TEST_CASE("filter: samples that are weighted in several pixels are uniform in their own") {
  for (const PixelFilter& f : all_filters()) {
    const FilterTable table = make_placement_table(f);
    const double side = std::min(0.5, filter_radius(f));
    for (int i = 0; i < 100; ++i) {
      const float u = (static_cast<float>(i) + 0.5f) / 100;
      const auto offset = table.sample<Scalar>(u);
      CHECK(double(offset.position) == near(side * (2 * double(u) - 1), 1e-4));
      CHECK(offset.weight == near(1));
    }
  }
}

TEST_CASE("filter: weighted samples have the moments of the filter with negative lobes included") {
  constexpr int kDraws = 1 << 18;
  for (const PixelFilter& f : all_filters()) {
    CAPTURE(static_cast<int>(f.kind));
    const FilterTable table = make_filter_table(f);
    const double radius = filter_radius(f), mass = integral(f, [&](double x) { return evaluate_filter(f, x); });
    const double gross = integral(f, [&](double x) { return std::fabs(evaluate_filter(f, x)); });
    double found[7] = {}, absolute = 0;
    for (int i = 0; i < kDraws; ++i) {
      const auto offset = table.sample<Scalar>((static_cast<float>(i) + 0.5f) / kDraws);
      double power = double(offset.weight) / kDraws;
      for (double& moment : found) {
        moment += power;
        power *= offset.position / radius;
      }
      absolute += std::fabs(offset.weight) / kDraws;
    }
    // Bins that contain a zero of the filter have less weight. There are at most four.
    CHECK(absolute <= gross / mass * (1 + 1e-5));
    CHECK(absolute >= gross / mass * (1 - 4.0 / FilterTable::kBins));
    CHECK(found[0] == near(1, 1e-5));
    for (int n = 0; n < 7; ++n) {
      const double expected =
          integral(f, [&](double x) { return evaluate_filter(f, x) * std::pow(x / radius, n); }) / mass;
      CHECK(std::fabs(found[n] - expected) < 2e-3);
    }
  }
}

TEST_CASE("filter: samples are distributed by the absolute value of the filter") {
  const std::vector<PixelFilter> filters = all_filters();
  for (const PixelFilter& f : filters) {
    CAPTURE(static_cast<int>(f.kind));
    const FilterTable table = make_filter_table(f);
    const double radius = filter_radius(f);
    const double gross = integral(f, [&](double x) { return std::fabs(evaluate_filter(f, x)); });
    const auto sample = [&](Random4<Scalar> u) -> std::optional<std::array<double, 2>> {
      return std::array<double, 2>{table.sample<Scalar>(u.x).position, table.sample<Scalar>(u.y).position};
    };
    // The outermost bins of a Gaussian cover much of its tails, where the table is coarser than the grid.
    const double edge = f.kind == Kind::kGaussian ? 0.75 * radius : radius;
    const auto density = [&](double x, double y) {
      return std::fabs(evaluate_filter(f, x) * evaluate_filter(f, y)) / (gross * gross);
    };
    const ChiSquare result = chi_square_plane(sample, density, {-edge, edge, -edge, edge, 24, 24}, 100000);
    CHECK(result.p_value > significance_of_each(static_cast<int>(filters.size())));
  }
}

TEST_CASE("filter: weights have the sign of the filter at the sample") {
  for (const PixelFilter& f : all_filters()) {
    const FilterTable table = make_filter_table(f);
    int wrong = 0;
    for (std::uint32_t i = 0; i < 100000; ++i) {
      const auto offset = table.sample<Scalar>((static_cast<float>(i) + 0.5f) / 100000);
      wrong += double(offset.weight) * evaluate_filter(f, offset.position) < 0;
    }
    CHECK(wrong <= 100000 / FilterTable::kBins * 6);  // bins that contain one of at most six zeros
  }
}

TEST_CASE("filter: offsets increase with the random number and cover the support") {
  for (const PixelFilter& f : all_filters()) {
    const FilterTable table = make_filter_table(f);
    const float radius = static_cast<float>(filter_radius(f));
    const auto position = [&](float u) { return table.sample<Scalar>(u).position; };
    float before = position(0);
    CHECK(before >= -radius);
    CHECK(before < -0.99f * radius);
    int falls = 0;
    for (int i = 1; i < 20000; ++i) {
      const float now = position(static_cast<float>(i) / 20000);
      falls += now < before;
      before = now;
    }
    CHECK(falls == 0);
    CHECK(position(0x1.fffffep-1f) > 0.99f * radius);
    CHECK(position(0x1.fffffep-1f) <= radius);
    CHECK(std::fabs(table.sample<Scalar>(0.5f).position) < 2e-3f * radius);
  }
}

TEST_CASE("filter: SIMD results equal scalar ones") {
  for (const PixelFilter& f : all_filters()) {
    const FilterTable table = make_filter_table(f);
    double worst = 0;
    for (std::uint32_t i = 0; i < 4096; i += kWidth) {
      const auto u =
          wide_floats([&](int lane) { return random4<Scalar>(4, i + static_cast<std::uint32_t>(lane), 0, 0).x; });
      const auto wide = table.sample<Wide>(u);
      for (int lane = 0; lane < kWidth; ++lane) {
        const auto one = table.sample<Scalar>(u[lane]);
        worst =
            std::max({worst, difference(wide.position[lane], one.position), difference(wide.weight[lane], one.weight)});
      }
    }
    CHECK(worst < 1e-6);
  }
}

TEST_CASE("filter: sizes that are not positive and finite are rejected") {
  for (const float size : {0.0f, -1.0f, 65.0f, kInfinity, std::numeric_limits<float>::quiet_NaN()}) {
    CAPTURE(size);
    PixelFilter f = filter(Kind::kBox);
    f.radius = size;
    CHECK_THROWS_AS(make_filter_table(f), SceneError);
    f = filter(Kind::kGaussian);
    f.stddev = size;
    CHECK_THROWS_AS(make_filter_table(f), SceneError);
    f = filter(Kind::kLanczos);
    f.lobes = size;
    CHECK_THROWS_AS(make_filter_table(f), SceneError);
  }
}

}  // namespace sheaf::test_filter
