// Renders of scenes whose radiance has a closed form. All pixels of an image have the same expectation, so that
// Student's t-test over the pixels tests the mean.
#pragma once

#include "kernels/render/render.h"
#include "scene/compile/compile.h"
#include "tests/support/statistics.h"
#include "tests/support/tiny_scenes.h"

#include <doctest/doctest.h>

#include <cmath>

namespace sheaf::closed_forms {

inline constexpr double kPiD = 3.14159265358979323846;
/// All comparisons with closed forms together fail with probability kSignificance if every estimator is unbiased.
inline const double kLevel = significance_of_each(600);
/// Relative error of single precision, which no number of samples averages out.
inline constexpr double kRounding = 2e-5;

/// Strategies for direct lighting, and their names.
inline constexpr LightStrategy kStrategies[] = {LightStrategy::kMis, LightStrategy::kBsdfOnly,
                                                LightStrategy::kLightOnly};
inline constexpr const char* kStrategyNames[] = {"mis", "bsdf only", "light only"};

/// An empty scene with an image of 32 x 32 pixels and 128 samples each.
inline Description small_scene() {
  Description d = empty_scene(32, 32);
  d.sampler.sample_count = 128;
  d.sampler.seed = 7;
  return d;
}

/// The camera looks at one point: over the image the position changes by a ten-thousandth of the distance.
inline void aim(Description& d, Vec3f from, Vec3f at, Vec3f up = {0, 0, 1}) { look_at(d, from, at, up, 0.01f); }

/// Renders an image.
inline Image render_image(const Description& d) { return render(*compile_scene(d), {}).film.to_image(); }

/// Statistics of a channel over the pixels.
inline MeanVariance statistics_of(const Image& image, int channel) {
  MeanVariance statistics;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) statistics.add(image.at(x, y, channel));
  return statistics;
}

/// Tests the mean against `expected`, within rounding.
inline void check_mean(const MeanVariance& statistics, double expected) {
  const double allowed = kRounding * std::fabs(expected), distance = statistics.mean() - expected;
  INFO("mean " << statistics.mean() << ", expected " << expected << ", standard error "
               << std::sqrt(statistics.variance() / 1024));
  const double nearest =
      std::fabs(distance) <= allowed ? statistics.mean() : expected + std::copysign(allowed, distance);
  CHECK(statistics.p_value(nearest) >= kLevel);
}

/// Tests the mean of red against `expected`, and that green and blue are equal to it.
inline void check_gray(const Description& d, double expected) {
  const Image image = render_image(d);
  check_mean(statistics_of(image, 0), expected);
  bool gray = true;
  for (std::size_t i = 0; i < image.data.size(); i += image.channels.size())
    gray = gray && image.data[i] == image.data[i + 1] && image.data[i] == image.data[i + 2];
  CHECK(gray);
}

/// Renders with each strategy; `sees_points` is false where BSDF sampling alone cannot find the light.
inline void check_strategies(Description d, double expected, bool sees_points = true) {
  for (int i = 0; i < 3; ++i) {
    d.integrator.strategy = kStrategies[i];
    CAPTURE(kStrategyNames[i]);
    check_gray(d, !sees_points && kStrategies[i] == LightStrategy::kBsdfOnly ? 0.0 : expected);
  }
}

}  // namespace sheaf::closed_forms
