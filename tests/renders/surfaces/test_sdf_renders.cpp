// Renders of signed distance grids against Mitsuba 3.
#include "tests/support/media_testing.h"
#include "tests/support/near.h"
#include "tests/support/render_testing.h"
#include "tests/support/tiny_scenes.h"

#include <doctest/doctest.h>

#include <cmath>

namespace sheaf::test_sdf_renders {

namespace {

/// A bumpy sphere in front of the camera, under a constant environment and a point light.
Description bumpy_ball(bool smooth, int samples) {
  Description d = empty_scene(32, 32);
  d.camera.fov = 28;
  d.sampler.sample_count = static_cast<std::uint32_t>(samples);
  constexpr int kSide = 20;
  SdfGrid grid{{kSide, kSide, kSide}, {}, smooth};
  for (int i = 0; i < kSide * kSide * kSide; ++i) {
    const int column = i % kSide, row = i / kSide % kSide, layer = i / kSide / kSide;
    const double x = column / (kSide - 1.0), y = row / (kSide - 1.0), z = layer / (kSide - 1.0);
    const double from = std::hypot(x - 0.5, y - 0.5, z - 0.5);
    grid.values.push_back(
        static_cast<float>(from - 0.3 + 0.05 * std::sin(12 * x) * std::sin(12 * y) * std::sin(12 * z)));
  }
  add_shape(d, grid, Transform::translate({-1, -1, 1.5f}) * Transform::scale({2, 2, 2}));
  d.lights.push_back({ConstantLightDescription{SpectrumDescription::constant(0.2f)}, {}});
  d.lights.push_back({PointLightDescription{{1, 2, 0}, SpectrumDescription::constant(5)}, {}});
  return d;
}

}  // namespace

TEST_CASE("sdf grid: images have the mean of Mitsuba") {
  // Mitsuba 3.9.1, scalar_rgb, `path` and `volpath`, 4 x 512 and 4 x 1024 samples per pixel; standard errors below
  // 3e-5.
  const auto check = [](const Description& d, double expected) {
    const double mean = pixel_means(d)[1].mean();
    CHECK(mean == near(expected, 3e-3));
  };
  for (const bool smooth : {true, false}) {
    Description d = bumpy_ball(smooth, 64);
    d.shapes[0].material = add_diffuse(d, 0.5f);
    check(d, smooth ? 0.157478 : 0.157608);
  }
  Description glass = bumpy_ball(false, 128);
  glass.shapes[0].material = add_glass(glass, 1.5046f, 1.000277f);
  check(glass, 0.2);  // a lossless object is invisible in the environment
  Description cloud = bumpy_ball(false, 128);
  cloud.shapes[0].material = add_material(cloud, NullDescription{});
  cloud.shapes[0].interior = add_medium(cloud, fog(2, 0.8f));
  check(cloud, 0.178198);
}

}  // namespace sheaf::test_sdf_renders
