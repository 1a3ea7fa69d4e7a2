// Whole renders in which every pixel has the same expected value, so that Student's t-test over the pixels tests the
// mean.
#pragma once

#include "kernels/render/render.h"
#include "scene/compile/compile.h"
#include "tests/support/statistics.h"
#include "tests/support/tiny_scenes.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace sheaf {

/// Strategies for direct lighting, named after the integrators.
struct NamedStrategy {
  LightStrategy strategy;
  const char* name;
};
inline constexpr NamedStrategy kLightStrategies[] = {
    {LightStrategy::kMis, "path"}, {LightStrategy::kBsdfOnly, "path_mats"}, {LightStrategy::kLightOnly, "path_ems"}};

/// An image of 32 x 32 pixels with independent samples.
inline Description one_point_scene(int samples) {
  Description d = empty_scene(32, 32);
  d.sampler.kind = SamplerKind::kIndependent;
  d.sampler.sample_count = static_cast<std::uint32_t>(samples);
  d.sampler.seed = 5;
  return d;
}

/// Points the camera at one point: directions vary by 1e-4 over the image.
inline void look_at_point(Description& d, Vec3f from, Vec3f at, Vec3f up = {0, 0, 1}) {
  look_at(d, from, at, up, 0.01f);
}

/// Red, green and blue means over the pixels of an image.
using PixelMeans = std::array<MeanVariance, 3>;

inline PixelMeans pixel_means(const Description& d, ColorMode color = ColorMode::kRgb) {
  CompileOptions options;
  options.color = color;
  const Image image = render(*compile_scene(d, options), {}).to_image();
  PixelMeans means;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      for (int c = 0; c < 3; ++c) means[static_cast<std::size_t>(c)].add(image.at(x, y, c));
  return means;
}

/// Tests whether a mean may equal `expected`. `allowed`: rounding error that more samples do not reduce.
inline void check_mean(const MeanVariance& found, double expected, double level, double allowed) {
  const double distance = found.mean() - expected;
  INFO("mean " << found.mean() << ", expected " << expected << ", deviation of a value "
               << std::sqrt(found.variance()));
  if (std::fabs(distance) > allowed) CHECK(found.p_value(expected + std::copysign(allowed, distance)) >= level);
}

/// Tests whether two images of `pixels` pixels may have the same mean.
inline void check_same_mean(const MeanVariance& a, const MeanVariance& b, double level, int pixels = 32 * 32) {
  const double error = std::sqrt((a.variance() + b.variance()) / pixels);
  INFO("means " << a.mean() << " and " << b.mean() << ", standard error of the difference " << error);
  REQUIRE(error > 0);
  CHECK(student_t_p_value((a.mean() - b.mean()) / error, 2 * pixels - 2) >= level);
}

/// Tests whether all strategies may have the same mean.
inline void check_strategies_agree(Description d, double level, ColorMode color = ColorMode::kRgb) {
  PixelMeans means[3];
  for (int i = 0; i < 3; ++i) {
    d.integrator.strategy = kLightStrategies[i].strategy;
    d.sampler.seed += 1;
    means[i] = pixel_means(d, color);
  }
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    CAPTURE(kLightStrategies[i].name);
    CAPTURE(kLightStrategies[j].name);
    for (std::size_t c = 0; c < 3; ++c) {
      CAPTURE(c);
      check_same_mean(means[i][c], means[j][c], level);
    }
  }
}

}  // namespace sheaf
