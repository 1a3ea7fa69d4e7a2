// Daylight: the models against values of Mitsuba 3.9.1 (plugin sunsky, evaluated in single directions), the map of the
// sky against the model, the position of the sun against date and time.
#include "scene/lights/daylight.h"

#include "kernels/lights/light_sample.h"
#include "scene/compile/compile.h"
#include "scene/dialects/common/sun_position.h"
#include "tests/support/files/scene_files.h"
#include "tests/support/near.h"
#include "tests/support/tiny_scenes.h"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

namespace sheaf::test_daylight {

namespace {

constexpr double kPiD = std::numbers::pi;
constexpr double kDegrees = kPiD / 180;

double angle(Vec3f a, Vec3f b) { return std::atan2(double(length(cross(a, b))), double(dot(a, b))); }

/// Checks three numbers with a relative tolerance.
template <class V> void check_near(const V& found, const std::array<double, 3>& expected, double part) {
  for (std::size_t c = 0; c < 3; ++c) CHECK(double(found[c]) == near(expected[c], part));
}
std::array<double, 3> numbers(Vec3f v) { return {double(v.x), double(v.y), double(v.z)}; }

SkyDescription sky_with(Vec3f sun) {
  SkyDescription sky;
  sky.suns = {normalize(sun)};
  return sky;
}

/// Irradiance of a plane with the given normal under a lone environment map.
Vec3f irradiance(const SceneView& scene, Vec3f normal) {
  std::array<double, 3> sum{};
  constexpr int kRows = 400;
  for (int i = 0; i < kRows; ++i)
    for (int k = 0; k < 4 * kRows; ++k) {
      const double polar = 0.5 * kPiD * (i + 0.5) / kRows, azimuth = 2 * kPiD * (k + 0.5) / (4 * kRows);
      const double z = std::cos(polar), r = std::sin(polar), weight = z * r;
      const Vec3f local{static_cast<float>(r * std::cos(azimuth)), static_cast<float>(r * std::sin(azimuth)),
                        static_cast<float>(z)};
      const auto value = lookup_envmap<Scalar>(scene.lights.envmap, Frame<Scalar>::from_normal(normal).to_world(local));
      sum[0] += weight * double(value.radiance.c0), sum[1] += weight * double(value.radiance.c1);
      sum[2] += weight * double(value.radiance.c2);
    }
  const double cell = kPiD * kPiD / (4.0 * kRows * kRows);
  return {static_cast<float>(sum[0] * cell), static_cast<float>(sum[1] * cell), static_cast<float>(sum[2] * cell)};
}

template <class Model> std::unique_ptr<Scene> lone(Model model) {
  Description d = empty_scene(4, 4);
  add_sphere(d, {0, 0, 3}, 1);
  d.lights.push_back({std::move(model), {"scene.xml", 9}});
  return compile_scene(d);
}

/// Irradiance of the sun on a plane that faces it.
Vec3f sun_irradiance(const SceneView& scene) {
  const auto s = sample_given_light<Scalar>(scene, {}, scene.lights.rows[0], {0.5f, 0.5f, 0.5f, 0.5f});
  const float scale = 1 / s.pdf_solid_angle;
  return {s.radiance.c0 * scale, s.radiance.c1 * scale, s.radiance.c2 * scale};
}

}  // namespace

TEST_CASE("daylight: the radiance of the sky matches reference values") {
  struct Case {
    float turbidity;
    Vec3f albedo, sun, direction;
    std::array<double, 3> expected;
  };
  const Case cases[] = {
      {3, {0.3f, 0.3f, 0.3f}, {0, 0.6f, 0.8f}, {0.3f, 0.4f, 0.6f}, {0.0684275, 0.0966627, 0.153089}},
      {1, {0, 0, 0}, {0.8f, 0, 0.6f}, {0.7f, 0.1f, 0.5f}, {0.039155, 0.067937, 0.128388}},
      {4.5f, {0.1f, 0.5f, 0.9f}, {0.99f, 0, 0.1f}, {-0.9f, 0.2f, 0.02f}, {0.0767582, 0.071885, 0.0478384}},
      {10, {1, 1, 1}, {0.2f, 0.1f, 0.9f}, {0.2f, 0.1f, 0.9f}, {1.32997, 1.3109, 1.11633}}};
  for (const Case& c : cases) {
    const Vec3f sun = normalize(c.sun), direction = normalize(c.direction);
    const SkyModel model(c.turbidity, c.albedo, std::asin(double(sun.z)));
    check_near(model.radiance(double(direction.z), angle(sun, direction)), c.expected, 1e-3);
  }
}

TEST_CASE("daylight: the color and spectrum of the sun match reference values") {
  struct Case {
    float turbidity;
    double elevation;
    std::array<double, 3> expected;
  };
  const Case cases[] = {{1, 60, {22508.1, 18902.5, 14535.2}},
                        {3, 50, {21580.8, 17872, 13411.9}},
                        {3, 10, {14494.3, 8789.18, 3141.14}},
                        {6.5f, 30, {16979.8, 13114.2, 8819.59}},
                        {10, 75, {14724.7, 11908.3, 9583.26}}};
  for (const Case& c : cases)
    // Near the horizon Mitsuba interpolates between elevations some degrees apart.
    check_near(numbers(sun_rgb(sun_spectrum(c.turbidity, c.elevation * kDegrees))), c.expected,
               c.elevation < 20 ? 0.012 : 5e-3);
  const auto noon = sun_spectrum(3, 50 * kDegrees), low = sun_spectrum(6.5f, 20 * kDegrees);
  REQUIRE(noon.wavelengths == std::vector<float>{320, 360, 400, 440, 480, 520, 560, 600, 640, 680, 720});
  check_near(std::array{noon.values[2], noon.values[6], 0.5f * (noon.values[9] + noon.values[10])},
             {8146.11, 16924.5, 15846.1}, 5e-3);
  check_near(std::array{low.values[2], low.values[6], 0.5f * (low.values[9] + low.values[10])},
             {2938.43, 10078.8, 11157.8}, 5e-3);
  // The model is continuous at the horizon, at the zenith and between its pieces.
  for (const double degrees : {1.0, 5.0, 33.0, 89.999}) {
    const auto below = sun_spectrum(4, (degrees - 1e-6) * kDegrees), above = sun_spectrum(4, degrees * kDegrees);
    CHECK(above.values[5] == near(below.values[5], 1e-3));
  }
}

TEST_CASE("daylight: the position of the sun follows from date and place") {
  const auto check_sun = [](const SunTime& time, std::array<double, 3> expected) {
    const auto found = sun_position(time);
    double squared = 0;
    for (std::size_t i = 0; i < 3; ++i) squared += (found[i] - expected[i]) * (found[i] - expected[i]);
    CHECK(std::sqrt(squared) < 2e-3);
  };
  // Mitsuba 3.9.1, from the position of its sun.
  check_sun({}, {-0.69161, -0.05173, 0.72042});
  check_sun({2015, 3, 5, 9.5, 0, 0, -30, 20, 1}, {0.57568, 0.31204, 0.75579});
  // At the equinox of 20 March 2015, 22:45 universal time, the sun is above the equator.
  const auto equinox = sun_position({2015, 3, 20, 22, 45, 0, 0, 0, 0});
  CHECK(std::fabs(equinox[1]) < 1e-4);
  // At the solstice of 21 June 2010 it is at the zenith of the tropic.
  double highest = 0;
  for (double hour = 11.5; hour < 12.5; hour += 0.01)
    highest = std::max(highest, sun_position({2010, 6, 21, hour, 0, 0, 23.4385, 0, 0})[2]);
  CHECK(highest > 1 - 1e-7);
  // By an independent implementation of the formulas, including the parallax of the low sun.
  const auto low = sun_position({2024, 6, 1, 6.5, 0, 0, 50, 8, 2});
  const double expected[3] = {0.8990178375158425, 0.4133479209249204, 0.1446043709414899};
  for (std::size_t i = 0; i < 3; ++i) CHECK(std::fabs(low[i] - expected[i]) < 1e-8);
  CHECK(days_since_2000({2000, 1, 1, 12, 0, 0, 0, 0, 0}) == 0);
  CHECK(days_since_2000({2004, 3, 1, 18, 0, 0, 0, 0, 0}) == near(1521.25, 1e-12));
}

TEST_CASE("daylight: the environment map of the sky has the radiance and irradiance of the model") {
  SkyDescription sky = sky_with({0.5f, 0.6f, 0.3f});
  const Vec3f up = sky.up = normalize(Vec3f{0.1f, 1, -0.2f});
  const auto scene = lone(sky);
  const SkyModel model(3, {0.3f, 0.3f, 0.3f}, std::asin(double(dot(up, sky.suns[0]))));
  const auto frame = Frame<Scalar>::from_normal(up);
  std::array<double, 3> sum{};
  constexpr int kSide = 300;
  for (int i = 0; i < kSide; ++i)
    for (int k = 0; k < kSide; ++k) {
      const Vec3f local = square_to_cosine_hemisphere<Scalar>((static_cast<float>(i) + 0.5f) / kSide,
                                                              (static_cast<float>(k) + 0.5f) / kSide);
      const auto value = model.radiance(double(local.z), angle(frame.to_world(local), sky.suns[0]));
      for (std::size_t c = 0; c < 3; ++c) sum[c] += value[c] * kPiD / (kSide * kSide);
    }
  check_near(numbers(irradiance(scene->view(), up)), sum, 2e-3);
  CHECK(max_component(irradiance(scene->view(), -up)) < 0.02 * sum[0]);
  // A scale of 3 triples the radiance. A stretched sky also shines from below.
  sky.scale = 3;
  check_near(numbers(irradiance(lone(sky)->view(), up)), {3 * sum[0], 3 * sum[1], 3 * sum[2]}, 2e-3);
  sky.scale = 1;
  sky.stretch = 2;
  const auto stretched_map = lone(sky);
  for (const double polar : {10.0, 80.0, 150.0}) {
    const Vec3f across =
        frame.s * static_cast<float>(std::sin(polar * kDegrees)) + up * static_cast<float>(std::cos(polar * kDegrees));
    const Vec3f within = frame.s * static_cast<float>(std::sin(polar / 2 * kDegrees)) +
                         up * static_cast<float>(std::cos(polar / 2 * kDegrees));
    const auto expected = model.radiance(std::cos(polar / 2 * kDegrees), angle(within, sky.suns[0]));
    CHECK(double(lookup_envmap<Scalar>(stretched_map->view().lights.envmap, across).radiance.c1) ==
          near(expected[1], 5e-3));
  }
  sky.stretch = 1;
  sky.extend = true;
  CHECK(irradiance(lone(sky)->view(), -up).y > 0.1 * sum[1]);
}

TEST_CASE("daylight: the irradiance of the sun does not depend on its size or representation") {
  SunDescription sun;
  sun.direction = normalize(Vec3f{0.5f, 0.8f, 0.2f});
  const auto plain = lone(sun);
  const Vec3f expected = sun_irradiance(plain->view());
  const double own = 2 * kPiD * (1 - std::cos(0.2679 * kDegrees));
  CHECK(double(expected.y) == near(own * double(sun_rgb(sun_spectrum(3, std::asin(double(sun.direction.y)))).y), 1e-4));
  for (const float radius : {0.0f, 0.05f, 3.0f, 45.0f}) {
    sun.radius = radius;
    const auto scene = lone(sun);
    CHECK(scene->view().lights.rows[0].is(radius > 0 ? kLightKind<SunLightKind> : kLightKind<DirectionalLightKind>));
    check_near(numbers(sun_irradiance(scene->view())), numbers(expected), 1e-4);
  }
  // A sun that moves across the sky, as part of the sky's map, with its own sky switched off.
  SkyDescription sky = sky_with(sun.direction);
  sky.suns.assign(8, sky.suns[0]);
  sky.suns[3] = sky.suns[5] = normalize(Vec3f{1, -1, 0});  // below the horizon
  sky.scale = 0;
  sky.sun_scale = 2;
  const Vec3f found = irradiance(lone(sky)->view(), sun.direction);
  check_near(numbers(found), {1.5 * expected.x, 1.5 * expected.y, 1.5 * expected.z}, 0.02);
}

TEST_CASE("daylight: a sun between texels of the map keeps its position and power") {
  const Vec3f front{0, 0, 1};
  SkyDescription sky;
  sky.scale = 0;
  sky.sun_scale = 1;
  sky.resolution = 64;
  constexpr double kElevation = 0.7;
  double brightness = 0;
  for (const double column : {0.5, 7.25, 20.0, 33.5, 48.9, 63.4, 63.75, -0.2, 0.0}) {
    CAPTURE(column);
    // Texel i is at longitude (i + 1/2) / 64 of a full turn from -z.
    const double azimuth = 2 * kPiD * (column + 0.5) / sky.resolution;
    const Frame<Scalar> frame{cross(sky.up, front), sky.up, front};
    const Vec3f sun = frame.to_world({static_cast<float>(std::sin(azimuth) * std::cos(kElevation)),
                                      static_cast<float>(std::sin(kElevation)),
                                      static_cast<float>(-std::cos(azimuth) * std::cos(kElevation))});
    sky.suns = {sun};
    const EnvmapImage image = sky_image(sky, front);
    double flux = 0, across = 0, down = 0;
    for (std::uint32_t j = 0; j < image.height; ++j)
      for (std::uint32_t i = 0; i < image.width; ++i) {
        const double value =
            double(image.rgb[3 * (j * image.width + i) + 1]) * node_solid_angle(j, image.width, image.height);
        flux += value;
        // Columns up to half of the map away from the sun's
        across += value * std::remainder(i - column, image.width);
        down += value * j;
      }
    REQUIRE(flux > 0);
    if (brightness == 0) brightness = flux;
    CHECK(flux == near(brightness, 1e-5));
    CHECK(std::fabs(across / flux) < 1e-4);
    CHECK(down / flux == near((0.5 - kElevation / kPiD) * (image.height - 1), 1e-4));
  }
}

TEST_CASE("daylight: a stretched sky moves the sun of its map away from the zenith") {
  SkyDescription sky;
  sky.scale = 0;
  sky.sun_scale = 1;
  sky.resolution = 64;
  sky.stretch = 1.5f;
  constexpr double kElevation = 0.9;
  sky.suns = {{static_cast<float>(std::cos(kElevation)), static_cast<float>(std::sin(kElevation)), 0}};
  const EnvmapImage image = sky_image(sky, {0, 0, 1});
  double flux = 0, down = 0;
  for (std::uint32_t j = 0; j < image.height; ++j)
    for (std::uint32_t i = 0; i < image.width; ++i) {
      const double value =
          double(image.rgb[3 * (j * image.width + i) + 1]) * node_solid_angle(j, image.width, image.height);
      flux += value, down += value * j;
    }
  CHECK(down / flux == near(1.5 * (0.5 - kElevation / kPiD) * (image.height - 1), 1e-4));
}

TEST_CASE("daylight: skies of several suns are averaged and the night sky is black") {
  SkyDescription first = sky_with({1, 1, 0}), second = sky_with({-0.2f, 0.3f, 0.5f}), both = first;
  for (SkyDescription* sky : {&first, &second, &both}) sky->resolution = 64;
  both.suns = {first.suns[0], second.suns[0], {0, -1, 0}, first.suns[0]};
  const Vec3f direction = normalize(Vec3f{0.3f, 0.7f, 0.6f});
  const auto at = [&](const SkyDescription& sky) {
    return double(lookup_envmap<Scalar>(lone(sky)->view().lights.envmap, direction).radiance.c2);
  };
  // To the rounding of texels, which have 10 bits
  CHECK(at(both) == near((2 * at(first) + at(second)) / 4, 1e-3));
  const auto night = lone(sky_with({1, -0.1f, 0}));
  CHECK(night->view().lights.count == 0);
  REQUIRE(night->warnings().size() == 1);
  CHECK(night->warnings()[0].find("scene.xml:9: the sky is black") != std::string::npos);
  SunDescription sun;
  sun.direction = {1, 0, 0}, sun.up = normalize(Vec3f{-0.1f, 1, 0});
  CHECK(lone(sun)->view().lights.count == 0);
}

}  // namespace sheaf::test_daylight
