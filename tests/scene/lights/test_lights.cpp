// Spot lights, projectors, directional lights, sun and sky against closed forms, and errors of lights.
#include "scene/compile/compile.h"
#include "tests/scene/lights/floor_lighting.h"
#include "tests/support/light_testing.h"
#include "tests/support/near.h"
#include "tests/support/tiny_scenes.h"

#include <doctest/doctest.h>

#include <cmath>
#include <memory>
#include <string>
#include <utility>

namespace sheaf::test_lights {

using namespace floor_lighting;

namespace {

constexpr double kDegrees = kPiD / 180;

/// A compiled scene of a single light.
template <class Model> std::unique_ptr<Scene> lone(Model model) {
  Description d = empty_scene(4, 4);
  d.lights.push_back({std::move(model), {"scene.xml", 9}});
  return compile_scene(d);
}

LightSample<Scalar> sample_at(const SceneView& scene, Vec3f from) {
  return sample_any_light<Scalar>(scene, from, {0.5f, 0.5f, 0.5f, 0.5f});
}

/// Flux of a lone light at the origin through the squares of [-half, half]^2 in the plane z = 1.
double flux(const SceneView& scene, double half) {
  constexpr int kSide = 800;
  double sum = 0;
  for (int j = 0; j < kSide; ++j)
    for (int i = 0; i < kSide; ++i) {
      const double x = half * (2 * (i + 0.5) / kSide - 1), y = half * (2 * (j + 0.5) / kSide - 1);
      const Vec3f p{static_cast<float>(x), static_cast<float>(y), 1};
      const auto s = sample_at(scene, p);
      if (s.valid) sum += double(s.radiance.c0) * std::fabs(s.direction.z);
    }
  return sum * 4 * half * half / (double(kSide) * kSide);
}

}  // namespace

TEST_CASE("lights: a linear spot light falls off linearly in the angle") {
  SpotLightDescription spot;
  spot.to_world = Transform::translate({1, 2, 3}) * Transform::rotate({0, 1, 0}, 90) * Transform::scale({2, 2, 2});
  spot.intensity = SpectrumDescription::constant(8);
  spot.cutoff_angle = 40;
  spot.beam_width = 10;
  const auto scene = lone(spot);
  const auto at = [&](double degrees) {
    const auto s = sample_at(scene->view(), {1 + 2 * static_cast<float>(std::cos(degrees * kDegrees)), 2,
                                             3 + 2 * static_cast<float>(std::sin(degrees * kDegrees))});
    CHECK((s.delta && s.pdf_solid_angle == 1.0f));
    return s.valid ? double(s.radiance.c0) : 0.0;
  };
  CHECK(at(0) == near(2));
  CHECK(at(9.9) == near(2));
  CHECK(at(25) == near(1));
  CHECK(at(37) == near(0.2));
  CHECK(at(40.1) == 0);
  CHECK(at(150) == 0);
}

TEST_CASE("lights: a smooth spot light has half its intensity at the mean of the cosines") {
  SpotLightDescription spot;
  spot.falloff = SpotLightDescription::Falloff::kSmooth;
  spot.cutoff_angle = 60;
  spot.beam_width = 20;
  const auto scene = lone(spot);
  const double middle = 0.5 * (std::cos(60 * kDegrees) + std::cos(20 * kDegrees));
  const auto at = [&](double cosine) {
    const auto sine = static_cast<float>(std::sqrt(1 - cosine * cosine));
    const auto s = sample_at(scene->view(), {sine, 0, static_cast<float>(cosine)});
    return s.valid ? double(s.radiance.c0) : 0.0;
  };
  CHECK(at(middle) == near(0.5));
  CHECK(at(std::cos(19 * kDegrees)) == near(1));
  CHECK(at(std::cos(61 * kDegrees)) == 0);
  const double quarter = std::cos(60 * kDegrees) + 0.25 * (std::cos(20 * kDegrees) - std::cos(60 * kDegrees));
  CHECK(at(quarter) == near(0.15625));
}

TEST_CASE("lights: the power of spot lights and projectors is their integrated flux") {
  SUBCASE("linear") {
    SpotLightDescription spot;
    spot.intensity = SpectrumDescription::constant(3);
    spot.cutoff_angle = 50;
    spot.beam_width = 20;
    const auto scene = lone(spot);
    const double c = 50 * kDegrees, b = 20 * kDegrees;
    const double expected = 2 * kPiD * 3 * (1 - (std::sin(c) - std::sin(b)) / (c - b));
    CHECK(flux(scene->view(), 1.3) == near(expected, 1e-3));
    CHECK(scene->view().lights.powers[0].x == near(expected, 1e-3));
  }
  SUBCASE("smooth") {
    SpotLightDescription spot;
    spot.falloff = SpotLightDescription::Falloff::kSmooth;
    spot.cutoff_angle = 50;
    spot.beam_width = 20;
    const auto scene = lone(spot);
    const double expected = kPiD * (2 - std::cos(20 * kDegrees) - std::cos(50 * kDegrees));
    CHECK(flux(scene->view(), 1.3) == near(expected, 1e-3));
    CHECK(scene->view().lights.powers[0].x == near(expected, 1e-3));
  }
  SUBCASE("textured") {
    Description d = empty_scene(4, 4);
    SpotLightDescription spot;
    spot.cutoff_angle = 45;
    spot.beam_width = 45;
    spot.texture = add_checkerboard(d, {2, 2, 2}, {0, 0, 0});
    d.lights.push_back({spot, {}});
    const auto scene = compile_scene(d);
    const double expected = 2 * kPiD * (1 - std::cos(45 * kDegrees));  // half of the cone at twice the intensity
    CHECK(flux(scene->view(), 1.1) == near(expected, 3e-3));
    CHECK(scene->view().lights.powers[0].x == near(expected, 1e-2));
    CHECK(sample_at(scene->view(), {-0.1f, -0.1f, 1}).radiance.c0 > 1);
    CHECK(sample_at(scene->view(), {0.1f, -0.1f, 1}).radiance.c0 == 0);
  }
  SUBCASE("projector") {
    ProjectorDescription projector;
    projector.irradiance = SpectrumDescription::constant(0.5f);
    projector.scale = 3;
    projector.fov = 60;
    const auto scene = lone(projector);
    const double expected = kPiD * 1.5 * 4 * std::tan(30 * kDegrees) * std::tan(30 * kDegrees);
    CHECK(flux(scene->view(), std::tan(30 * kDegrees) * 1.0001) == near(expected, 2e-3));
    CHECK(scene->view().lights.powers[0].x == near(expected, 1e-4));
    CHECK_FALSE(sample_at(scene->view(), {0, 0.6f, 1}).valid);
    CHECK_FALSE(sample_at(scene->view(), {0, 0, -1}).valid);
  }
}

TEST_CASE("lights: a directional light has the closed-form irradiance") {
  Description d = floor_scene();
  DirectionalLightDescription light;
  light.direction = {0, 3, -4};
  light.irradiance = SpectrumDescription::constant(2);
  d.lights.push_back({light, {}});
  const auto scene = compile_scene(d);
  const auto s = sample_at(scene->view(), {0.1f, 0.2f, 0});
  CHECK((s.valid && s.delta && s.pdf_solid_angle == 1.0f));
  CHECK(length(s.direction - Vec3f{0, -0.6f, 0.8f}) < 1e-6f);
  CHECK(length(s.target - scene->view().center) > scene->view().radius);
  CHECK(rendered(d).mean == near(0.5 / kPiD * 2 * 0.8, 1e-5));
  // BSDF sampling alone cannot find it.
  d.integrator.strategy = LightStrategy::kBsdfOnly;
  CHECK(rendered(d).mean == 0);
}

TEST_CASE("lights: all strategies agree on sun and sky") {
  Description d = floor_scene();
  SunDescription sun;
  sun.up = {0, 0, 1};
  sun.direction = normalize(Vec3f{0.3f, 0.2f, 0.8f});
  sun.radius = 20;
  d.lights.push_back({sun, {}});
  const auto scene = compile_scene(d);
  const LightRow& row = scene->view().lights.rows[0];
  // Irradiance of a cone above the horizon: pi sin^2 of its half angle times the cosine of its axis.
  const double cosine = double(sun.direction.z), disk = kPiD * std::pow(std::sin(20 * kDegrees), 2);
  CHECK(agreed(d) == near(0.5 / kPiD * double(row.radiance.c0) * disk * cosine, 0.01));
  SkyDescription sky;
  sky.up = sun.up;
  sky.suns = {sun.direction};
  sky.resolution = 64;
  sky.scale = 1e4f;
  d.lights.push_back({sky, {}});
  agreed(d, 1);
}

TEST_CASE("lights: unsupported lights are errors with file and line") {
  const auto message = [](auto model) -> std::string {
    try {
      lone(model);
    } catch (const SceneError& error) { return error.what(); }
    return "";
  };
  SpotLightDescription spot;
  spot.beam_width = 30;
  CHECK(message(spot).starts_with("scene.xml:9: the beam of a spot light"));
  spot = {};
  spot.cutoff_angle = 0;
  CHECK(message(spot).find("between 0 and 180") != std::string::npos);
  DirectionalLightDescription nowhere;
  nowhere.direction = {0, 0, 0};
  CHECK(message(nowhere).find("no length") != std::string::npos);
  ProjectorDescription projector;
  projector.to_world = Transform::scale({1, 2, 1});
  CHECK(message(projector).find("stretched") != std::string::npos);
  projector = {};
  projector.fov = 180;
  CHECK(message(projector).find("field of view") != std::string::npos);
  spot = {};
  spot.texture = TextureId{3};
  CHECK(message(spot).find("does not exist") != std::string::npos);
}

}  // namespace sheaf::test_lights
