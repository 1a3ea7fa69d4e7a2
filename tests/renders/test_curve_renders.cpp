// Light on curves against Mitsuba 3.
#include "tests/support/render_testing.h"
#include "tests/support/tiny_scenes.h"

#include <doctest/doctest.h>

#include <cmath>

using namespace sheaf;

namespace {

/// Twelve curves in front of the camera, of changing radius, under a sky and a point light.
Description tuft(Curves::Basis basis) {
  Description d = empty_scene(32, 32);
  d.camera.fov = 60;
  d.sampler.sample_count = 128;
  Curves curves;
  curves.basis = basis;
  for (int i = 0; i < 12; ++i) {
    curves.starts.push_back(static_cast<std::uint32_t>(curves.points.size()));
    for (int k = 0; k < 6; ++k) {
      const auto x = static_cast<float>(i), y = static_cast<float>(k);
      curves.points.push_back(
          {{0.1f * x - 0.55f + 0.1f * std::sin(0.5f * x + y), 0.5f * y - 1.25f, 2.5f + 0.15f * std::cos(x + y)},
           0.05f + 0.02f * static_cast<float>(k % 3)});
    }
  }
  add_shape(d, curves, Transform(), add_diffuse(d, 0.5f));
  d.lights.push_back({ConstantLightDescription{SpectrumDescription::constant(0.2f)}, {}});
  d.lights.push_back({PointLightDescription{{1, 2, 0}, SpectrumDescription::constant(5)}, {}});
  return d;
}

}  // namespace

TEST_CASE("curves: pictures of them have Mitsuba's mean") {
  // Mitsuba 3.9.1, scalar_rgb, `path`, 4 x 1024 samples per pixel; standard errors 1.5e-5 and 2.8e-5.
  const auto check = [](Curves::Basis basis, double expected) {
    const double mean = pixel_means(tuft(basis))[1].mean();
    CHECK(mean == doctest::Approx(expected).epsilon(2e-3));
  };
  check(Curves::Basis::kBspline, 0.183822);
  check(Curves::Basis::kLinear, 0.172356);
}
