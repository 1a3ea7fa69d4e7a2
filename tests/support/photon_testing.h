// Support for tests of photon mapping: a room, and mean values to compare with the path tracer. Photon maps have the
// same expectation except for the blur by the radius.
#pragma once

#include "kernels/render/render.h"
#include "scene/compile/compile.h"
#include "tests/support/media_testing.h"
#include "tests/support/statistics.h"
#include "tests/support/tiny_scenes.h"

#include <doctest/doctest.h>

#include <array>
#include <cmath>

namespace sheaf {

/// All comparisons of a test file together fail with probability kSignificance if every estimator is correct.
inline const double kPhotonLevel = significance_of_each(100);

/// Side of the room's images in pixels. Photon noise depends little on the number of pixels.
inline constexpr int kRoomSide = 16;

/// A room with a light below its ceiling, a glass or diffuse ball on its floor, and a camera inside.
inline Description room(bool glass, std::uint32_t samples) {
  Description d = empty_scene(kRoomSide, kRoomSide);
  d.sampler.sample_count = samples;
  look_at(d, {0, -1.9f, 1}, {0, 0, 0.7f}, {0, 0, 1}, 60);
  d.integrator.rr_depth = 20;
  d.integrator.max_depth = 8;
  ShapeDescription& walls = add_shape(d, CubeShape{}, Transform::translate({0, 0, 1}) * Transform::scale({2, 2, 1}),
                                      add_diffuse_rgb(d, 0.6f, 0.5f, 0.4f));
  walls.flip_normals = true;
  emit(add_rectangle(d,
                     Transform::translate({0.4f, 0.2f, 1.98f}) * Transform::rotate({1, 0, 0}, 180) *
                         Transform::scale({0.3f, 0.3f, 1}),
                     add_diffuse(d, 0)),
       10);
  add_sphere(d, {-0.2f, 0.3f, 0.55f}, 0.5f, glass ? add_glass(d) : add_diffuse(d, 0.7f));
  return d;
}

/// The mean of an image.
struct Mean {
  double value, variance;  ///< of the mean
};
inline Mean mean_of(const Description& d, int repeats = 8) {
  const auto scene = compile_scene(d);
  MeanVariance mean;
  for (int i = 0; i < repeats; ++i) {
    RenderOptions options;
    options.seed = static_cast<std::uint32_t>(i + 1);
    const Image image = render(*scene, options).to_image();
    double sum = 0;
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x) sum += static_cast<double>(image.at(x, y, 1));
    mean.add(sum / (image.width * image.height));
  }
  return {mean.mean(), mean.variance() / repeats};
}

/// Channel means of images in spectral mode.
inline std::array<MeanVariance, 3> spectral_mean_of(const Description& d) {
  const auto scene = compile_scene(d, {.color = ColorMode::kSpectral});
  std::array<MeanVariance, 3> mean;
  for (std::uint32_t seed = 1; seed <= 8; ++seed) {
    RenderOptions options;
    options.seed = seed;
    const Image image = render(*scene, options).to_image();
    for (int c = 0; c < 3; ++c) {
      double sum = 0;
      for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) sum += static_cast<double>(image.at(x, y, c));
      mean[static_cast<std::size_t>(c)].add(sum / (image.width * image.height));
    }
  }
  return mean;
}

/// mean_of() by the path tracer, with many samples.
inline Mean path_mean(Description d, int samples = 400) {
  d.integrator.kind = IntegratorKind::kPath;
  d.sampler.sample_count = samples;
  return mean_of(d);
}

inline void check_close(const Mean& found, const Mean& expected, double bias) {
  const double error = std::sqrt(found.variance + expected.variance);
  INFO("mean " << found.value << ", path tracer " << expected.value << ", standard error " << error);
  const double distance = std::fabs(found.value - expected.value) - bias * expected.value;
  if (distance > 0) CHECK(student_t_p_value(distance / error, 14) >= kPhotonLevel);
}

}  // namespace sheaf
