// A floor under lights, of which the camera sees one point, and renders of it by every strategy for direct light.
#pragma once

#include "kernels/render/render.h"
#include "scene/compile/compile.h"
#include "tests/support/statistics.h"
#include "tests/support/tiny_scenes.h"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

namespace sheaf::floor_lighting {

inline constexpr double kPiD = std::numbers::pi;

/// Mean of the pixels of an image, and its standard error.
struct Result {
  double mean, error;
};

/// Renders a channel.
inline Result rendered(const Description& d, int channel = 0) {
  const Image image = render(*compile_scene(d), {}).film.to_image();
  MeanVariance statistics;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) statistics.add(image.at(x, y, channel));
  return {statistics.mean(), std::sqrt(statistics.variance() / static_cast<double>(image.pixel_count()))};
}

/// A white floor at the origin, of which the camera sees one point.
inline Description floor_scene() {
  Description d = empty_scene(24, 24);
  d.sampler.sample_count = 256;
  d.integrator.max_depth = 2;
  look_at(d, {2.8f, 0.1f, 0.3f}, {0, 0, 0}, {0, 0, 1}, 0.01f);
  add_rectangle(d, Transform::scale({3, 3, 3}), add_diffuse(d, 0.5f));
  return d;
}

/// Checks that all strategies agree within their errors and returns the mean.
inline double agreed(Description d, int channel = 0) {
  Result results[3];
  for (int i = 0; i < 3; ++i) {
    constexpr LightStrategy kAll[] = {LightStrategy::kMis, LightStrategy::kBsdfOnly, LightStrategy::kLightOnly};
    d.integrator.strategy = kAll[i];
    results[i] = rendered(d, channel);
    CAPTURE(i);
    CAPTURE(results[i].mean);
    CAPTURE(results[0].mean);
    CHECK(results[i].mean > 0);
    CHECK(results[i].error < 0.02 * results[i].mean);
    const double sigma = std::hypot(results[i].error, results[0].error);
    CHECK(std::fabs(results[i].mean - results[0].mean) <= 4.5 * sigma + 1e-5 * results[0].mean);
  }
  return results[0].mean;
}

}  // namespace sheaf::floor_lighting
