// Renders of curves and hair against Mitsuba 3.
#include "tests/support/near.h"
#include "tests/support/render_testing.h"
#include "tests/support/tiny_scenes.h"

#include <doctest/doctest.h>

#include <cmath>

namespace sheaf::test_curve_renders {

namespace {

/// Twelve curves of varying radius in front of the camera.
Description bare_tuft(Curves::Basis basis) {
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
  return d;
}

void add_sky(Description& d) {
  d.lights.push_back({ConstantLightDescription{SpectrumDescription::constant(0.2f)}, {}});
}

/// Adds a point light at `z`; z = 5 is behind the curves.
void add_point_light(Description& d, float z) {
  d.lights.push_back({PointLightDescription{{1, 2, z}, SpectrumDescription::constant(5)}, {}});
}

/// The curves under a constant environment and a point light.
Description tuft(Curves::Basis basis) {
  Description d = bare_tuft(basis);
  add_sky(d);
  add_point_light(d, 0);
  return d;
}

Description hairy_tuft(Curves::Basis basis, const HairDescription& hair) {
  Description d = bare_tuft(basis);
  d.materials[0].model = hair;
  return d;
}

HairDescription dyed_hair() {
  HairDescription hair;
  hair.color = HairDescription::Absorption{SpectrumDescription::rgb(0.1f, 0.3f, 0.9f), 0.5f};
  hair.longitudinal_roughness = 0.15f, hair.azimuthal_roughness = 0.5f;
  hair.scale_tilt = 8;
  hair.int_ior = 1.4f;
  return hair;
}

/// Checks that photons and paths give the same mean of a channel. `max_error`: largest relative standard error of the
/// difference.
void check_photons_agree(Description d, int channel, double max_error, double level) {
  constexpr int kRepeats = 8;
  MeanVariance means[2];
  for (const bool photons : {false, true}) {
    d.integrator.kind = photons ? IntegratorKind::kLightTracer : IntegratorKind::kPath;
    const auto scene = compile_scene(d);
    for (std::uint32_t i = 0; i < kRepeats; ++i) {
      RenderOptions options;
      options.seed = 2 * i + (photons ? 1 : 0);
      const Image image = render(*scene, options).to_image();
      double sum = 0;
      for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) sum += double{image.at(x, y, channel)};
      means[photons ? 1 : 0].add(sum / static_cast<double>(image.pixel_count()));
    }
  }
  const double error = std::sqrt((means[0].variance() + means[1].variance()) / kRepeats);
  INFO("paths " << means[0].mean() << ", photons " << means[1].mean() << ", standard error " << error);
  CHECK(error < max_error * means[0].mean());
  CHECK(student_t_p_value((means[0].mean() - means[1].mean()) / error, 2 * kRepeats - 2) >= level);
}

}  // namespace

TEST_CASE("curves: images have the mean of Mitsuba") {
  // Mitsuba 3.9.1, scalar_rgb, `path`, 4 x 1024 samples per pixel; standard errors 1.5e-5 and 2.8e-5.
  const auto check = [](Curves::Basis basis, double expected) {
    const double mean = pixel_means(tuft(basis))[1].mean();
    CHECK(mean == near(expected, 2e-3));
  };
  check(Curves::Basis::kBspline, 0.183822);
  check(Curves::Basis::kLinear, 0.172356);
}

TEST_CASE("curves: images of hair have the mean of Mitsuba") {
  // Mitsuba 3.9.1, scalar_rgb, `path`, 4 x 512 samples per pixel; standard errors 1e-5 and 3e-5.
  const auto check = [](const HairDescription& hair, Vec3f expected) {
    Description d = hairy_tuft(Curves::Basis::kBspline, hair);
    add_sky(d);
    add_point_light(d, 5);
    add_point_light(d, 0);
    const auto means = pixel_means(d);
    CHECK(means[0].mean() == near(expected.x, 3e-3));
    CHECK(means[1].mean() == near(expected.y, 3e-3));
    CHECK(means[2].mean() == near(expected.z, 3e-3));
  };
  check(HairDescription(), {0.169736f, 0.162096f, 0.157019f});
  check(dyed_hair(), {0.195737f, 0.185930f, 0.170230f});
}

TEST_CASE("curves: hair without absorption is invisible in a constant environment") {
  HairDescription white;
  white.color = HairDescription::Absorption{};
  for (const Curves::Basis basis : {Curves::Basis::kBspline, Curves::Basis::kLinear}) {
    Description d = hairy_tuft(basis, white);
    d.sampler.sample_count = 32;
    add_sky(d);
    CHECK(pixel_means(d)[1].mean() == near(0.2, 2e-3));
  }
}

TEST_CASE("curves: photons scattered by thin hair give the image of paths") {
  // Paths scatter where the camera sees a fiber, and photons where they enter. That is the same for fibers much thinner
  // than their distances to the light, the camera and each other.
  Description d = hairy_tuft(Curves::Basis::kBspline, dyed_hair());
  for (auto& point : std::get<Curves>(d.shapes[0].geometry).points) point.radius *= 0.1f;
  add_point_light(d, 0);
  d.integrator.max_depth = 3;
  d.sampler.sample_count = 256;
  check_photons_agree(d, 1, 0.05, kSignificance);
}

TEST_CASE("curves: photons and paths agree around a single fiber") {
  // With parallel light and parallel rays, it does not matter that paths scatter where the camera sees the fiber and
  // photons where they enter. Light that passes off the axis must leave on the side where paths find it.
  constexpr double kLevelOfEach = kSignificance / 8;
  for (const float azimuth : {10.0f, 65.0f, 90.0f, 115.0f, 150.0f, 178.0f, 240.0f, 290.0f}) {
    CAPTURE(azimuth);
    Description d = empty_scene(16, 16);
    d.camera.projection = CameraDescription::Projection::kOrthographic;
    d.sampler.sample_count = 128;
    d.integrator.max_depth = 2;
    HairDescription hair = dyed_hair();
    hair.azimuthal_roughness = 0.2f;
    Curves fiber;
    fiber.basis = Curves::Basis::kLinear;
    fiber.starts = {0};
    fiber.points = {{{0, -2, 3}, 0.5f}, {{0, 2, 3}, 0.5f}};
    add_shape(d, fiber, Transform(), add_material(d, hair));
    const float angle = azimuth * kPi / 180;
    d.lights.push_back({DirectionalLightDescription{normalize(Vec3f{std::sin(angle), 0.3f, std::cos(angle)}),
                                                    SpectrumDescription::constant(1)},
                        {}});
    check_photons_agree(d, 0, 0.04, kLevelOfEach);
  }
}

}  // namespace sheaf::test_curve_renders
