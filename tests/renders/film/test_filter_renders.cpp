// Renders under every pixel filter: constant images, and straight edges against the integral of the filter.
#include "tests/renders/light/closed_forms.h"

#include <doctest/doctest.h>

#include <cmath>
#include <vector>

namespace sheaf::test_filter_renders {

using namespace closed_forms;

namespace {

using FilterKind = PixelFilter::Kind;

std::vector<PixelFilter> all_filters() {
  std::vector<PixelFilter> filters;
  for (FilterKind kind : {FilterKind::kBox, FilterKind::kTent, FilterKind::kGaussian, FilterKind::kMitchell,
                          FilterKind::kCatmullRom, FilterKind::kLanczos}) {
    PixelFilter filter;
    filter.kind = kind;
    if (kind == FilterKind::kTent) filter.radius = 1;
    filters.push_back(filter);
  }
  return filters;
}

/// Fraction of the integral of the filter to the left of `x`.
double filter_fraction(const PixelFilter& filter, double x) {
  const double radius = filter_radius(filter);
  constexpr int kSteps = 100000;
  double left = 0, all = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double at = radius * ((2 * i + 1.0) / kSteps - 1), f = evaluate_filter(filter, at);
    all += f;
    if (at < x) left += f;
  }
  return left / all;
}

}  // namespace

TEST_SUITE_BEGIN("slow");

TEST_CASE("a constant image stays constant under every filter") {
  for (const PixelFilter& filter : all_filters()) {
    CAPTURE(static_cast<int>(filter.kind));
    Description d = small_scene();
    d.film.filter = filter;
    add_constant_light(d, 3);
    const Image image = render_image(d);
    check_mean(statistics_of(image, 0), 3);
    check_mean(statistics_of(image, 3), 1);
    if (filter.kind < FilterKind::kMitchell) CHECK(statistics_of(image, 0).variance() < 1e-12);
  }
}

TEST_CASE("a straight edge shows the integral of every filter") {
  constexpr double kEdge = 32.3;  // pixels from the left, beside a seam of tiles
  for (const PixelFilter& filter : all_filters()) {
    CAPTURE(static_cast<int>(filter.kind));
    Description d = empty_scene(64, 32);
    d.sampler.sample_count = 128;
    d.film.filter = filter;
    const auto edge = static_cast<float>(1 - kEdge / 32);
    add_area_light_rectangle(
        d, Transform::translate({edge + 50, 0, 1}) * Transform::rotate({0, 1, 0}, 180) * Transform::scale({50, 50, 1}),
        1);
    const Image image = render_image(d);
    for (int x = 0; x < image.width; ++x) {
      CAPTURE(x);
      MeanVariance column;
      for (int y = 0; y < image.height; ++y) column.add(image.at(x, y, 0));
      const double expected = filter_fraction(filter, kEdge - (x + 0.5));
      // The table of 2048 bins smooths the sign changes of filters with negative lobes.
      const double allowed = 2e-3, distance = column.mean() - expected;
      INFO("mean " << column.mean() << ", expected " << expected);
      if (std::fabs(distance) > allowed) CHECK(column.p_value(expected + std::copysign(allowed, distance)) >= kLevel);
    }
  }
}

TEST_SUITE_END();

}  // namespace sheaf::test_filter_renders
