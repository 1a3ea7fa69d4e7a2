// Direct light of every shape against closed forms, and hidden lights.
#include "tests/renders/light/closed_forms.h"
#include "tests/support/capture.h"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <utility>
#include <vector>

namespace sheaf::test_direct_light {

using namespace closed_forms;

namespace {

constexpr float kAlbedo = 0.6f;

/// A diffuse floor at z = 0, which the camera sees at the origin from a low angle.
Description receiver() {
  Description d = small_scene();
  add_rectangle(d, Transform::scale({20, 20, 1}), add_diffuse(d, kAlbedo));
  d.integrator.max_depth = 2;
  aim(d, {8, 0, 2}, {0, 0, 0});
  return d;
}

/// Radiance of the floor under an irradiance.
double reflected(double irradiance) { return kAlbedo / kPiD * irradiance; }

Transform facing_down(Vec3f at) { return Transform::translate(at) * Transform::rotate({1, 0, 0}, 180); }

ShapeDescription& add_disk_light(Description& d, Vec3f at, float radius, float radiance) {
  const MaterialId black = add_diffuse(d, 0);
  return emit(add_shape(d, DiskShape{}, facing_down(at) * Transform::scale({radius, radius, 1}), black), radiance);
}

/// Irradiance of a polygon at the origin of a floor with normal +z (Lambert's formula). All corners are above the
/// floor.
double polygon_irradiance(const std::vector<std::array<double, 3>>& corners, double radiance) {
  double sum = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const auto &a = corners[i], &b = corners[(i + 1) % corners.size()];
    const double cross[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
    const double length = std::hypot(cross[0], cross[1], cross[2]);
    sum += std::atan2(length, a[0] * b[0] + a[1] * b[1] + a[2] * b[2]) * cross[2] / length;
  }
  return radiance / 2 * std::fabs(sum);
}

}  // namespace

TEST_SUITE_BEGIN("slow");

TEST_CASE("a disk light above a parallel floor matches the closed form") {
  for (const auto& [radius, height] : {std::pair{1.0, 1.0}, {0.3, 2.0}, {4.0, 1.0}}) {
    CAPTURE_BINDING(radius);
    Description d = receiver();
    add_disk_light(d, {0, 0, static_cast<float>(height)}, static_cast<float>(radius), 3);
    if (radius > 2) aim(d, {8, 0, 0.5f}, {0, 0, 0});
    check_strategies(d, reflected(kPiD * 3 * radius * radius / (radius * radius + height * height)));
  }
}

TEST_CASE("an occluder removes its share of a disk light") {
  Description d = receiver();
  add_disk_light(d, {0, 0, 2}, 1.5f, 3);
  const MaterialId black = add_diffuse(d, 0);
  add_shape(d, DiskShape{}, facing_down({0, 0, 1}) * Transform::scale({0.5f, 0.5f, 1}), black);
  check_strategies(d, reflected(kPiD * 3 * (2.25 / 6.25 - 0.25 / 1.25)));
}

TEST_CASE("a sphere light matches the closed form") {
  Description d = receiver();
  SUBCASE("overhead") {
    add_area_light_sphere(d, {0, 0, 1}, 0.5f, 2);
    check_strategies(d, reflected(kPiD * 2 * 0.25));
  }
  SUBCASE("beside the point by a transform") {
    const MaterialId black = add_diffuse(d, 0);
    const Transform t =
        Transform::translate({-2, 1, 2}) * Transform::rotate({1, 2, 3}, 40) * Transform::scale({0.5f, 0.5f, 0.5f});
    emit(add_shape(d, SphereShape{}, t, black), 5);
    check_strategies(d, reflected(kPiD * 5 * (0.25 / 9) * (2.0 / 3)));
  }
  SUBCASE("an ellipsoid overhead") {
    const MaterialId black = add_diffuse(d, 0);
    emit(add_shape(d, SphereShape{}, Transform::translate({0, 0, 2}) * Transform::scale({1, 1, 0.5f}), black), 2);
    check_strategies(d, reflected(kPiD * 2 / (1 + 4 - 0.25)));
  }
}

TEST_CASE("a cylinder light matches quadrature over its surface") {
  constexpr double kRadius = 0.4, kHeight = 1.2, kHalfLength = 0.8;
  Description d = receiver();
  const MaterialId black = add_diffuse(d, 0);
  emit(add_shape(d, CylinderShape{{-0.8f, 0, 1.2f}, {0.8f, 0, 1.2f}, 0.4f}, Transform(), black), 2);
  double irradiance = 0;
  constexpr int kSteps = 1000;
  for (int i = 0; i < kSteps; ++i)
    for (int j = 0; j < kSteps; ++j) {
      const double phi = 2 * kPiD * (i + 0.5) / kSteps, x = kHalfLength * (2 * (j + 0.5) / kSteps - 1);
      const double y = kRadius * std::cos(phi), z = kHeight + kRadius * std::sin(phi);
      const double squared = x * x + y * y + z * z;
      const double facing = -(y * std::cos(phi) + z * std::sin(phi));
      if (facing > 0) irradiance += 2 * facing * z / (squared * squared);
    }
  irradiance *= 2 * kPiD * kRadius * 2 * kHalfLength / (double(kSteps) * kSteps);
  check_strategies(d, reflected(irradiance));
}

TEST_CASE("rectangle lights and mesh lights of unequal triangles match the closed form") {
  Description d = receiver();
  SUBCASE("rectangle") {
    add_area_light_rectangle(d, facing_down({0.5f, 0, 1}) * Transform::scale({1, 0.5f, 1}), 4);
    check_strategies(
        d, reflected(polygon_irradiance({{-0.5, -0.5, 1}, {1.5, -0.5, 1}, {1.5, 0.5, 1}, {-0.5, 0.5, 1}}, 4)));
  }
  SUBCASE("mesh") {
    Mesh mesh;
    mesh.positions = {{-1, -1, 1}, {-1, 1, 2}, {0.5f, 0.25f, 1}, {-1.5f, -1.5f, 0.5f}};
    mesh.triangles = {{{0, 1, 2}}, {{0, 3, 1}}};
    const MaterialId black = add_diffuse(d, 0);
    emit(add_shape(d, mesh, Transform(), black), 4);
    const double a = polygon_irradiance({{-1, -1, 1}, {-1, 1, 2}, {0.5, 0.25, 1}}, 4);
    const double b = polygon_irradiance({{-1, -1, 1}, {-1.5, -1.5, 0.5}, {-1, 1, 2}}, 4);
    check_strategies(d, reflected(a + b));
  }
}

TEST_CASE("a point light matches the closed form") {
  Description d = receiver();
  add_point_light(d, {-1, 2, 2}, 10);
  check_strategies(d, reflected(10 * (2.0 / 3) / 9), false);
}

TEST_CASE("lights of all kinds add up whatever their power") {
  Description d = receiver();
  add_area_light_sphere(d, {0, 0, 2}, 0.5f, 2);
  add_area_light_rectangle(d, facing_down({-4, 0, 2}) * Transform::scale({1, 1, 1}), 30);
  add_constant_light(d, 0.5f);
  const double sphere = 0.25 / 4;  // fraction of the cosine-weighted hemisphere of the floor
  const double rectangle = polygon_irradiance({{-5, -1, 2}, {-3, -1, 2}, {-3, 1, 2}, {-5, 1, 2}}, 1) / kPiD;
  const double area_lights = kPiD * (2 * sphere + 30 * rectangle + 0.5 * (1 - sphere - rectangle));
  SUBCASE("without a point light") { check_strategies(d, reflected(area_lights)); }
  SUBCASE("with a point light") {
    add_point_light(d, {0, -2, 2}, 0.3f);
    d.integrator.strategy = LightStrategy::kMis;
    check_gray(d, reflected(area_lights + 0.3 * std::sqrt(0.5) / 8));
  }
}

TEST_CASE("hidden lights are invisible to the camera but illuminate and are reflected") {
  Description d = small_scene();
  d.integrator.hide_emitters = true;
  d.integrator.max_depth = 2;
  double value = 0, alpha = 0;
  SUBCASE("an area light before a black background") {
    add_area_light_rectangle(d, facing_down({0, 0, 2}), 3);
    aim(d, {0, 0.1f, 0}, {0, 0, 2}, {0, 1, 0});
  }
  SUBCASE("an environment") { add_constant_light(d, 3); }
  SUBCASE("area lights before a lit wall") {
    add_area_light_rectangle(d, Transform::translate({0, 0, 1}), 3);
    add_area_light_rectangle(d, facing_down({0, 0, 1.5f}), 0.25f);
    add_rectangle(d, Transform::scale({20, 20, 1}), add_diffuse(d, kAlbedo));
    add_point_light(d, {5, 0, 0.5f}, 100);
    aim(d, {0, 0, 3}, {0, 0, 0}, {0, 1, 0});
    value = reflected(100 * 0.5 / std::pow(25.25, 1.5));
    alpha = 1;
    d.integrator.strategy = LightStrategy::kLightOnly;
  }
  SUBCASE("a hidden light still shows in a mirror") {
    add_rectangle(d, Transform::scale({5, 5, 1}), add_mirror(d, 0.5f));
    add_area_light_rectangle(d, facing_down({-2, 0, 2}), 3);
    aim(d, {2, 0, 2}, {0, 0, 0});
    value = 1.5;
    alpha = 1;
  }
  SUBCASE("a hidden light still lights") {
    add_rectangle(d, Transform::scale({5, 5, 1}), add_diffuse(d, kAlbedo));
    add_disk_light(d, {0, 0, 1}, 1, 3);
    aim(d, {0.1f, 0, 5}, {0, 0, 0});
    value = reflected(kPiD * 3 * 0.5);
    alpha = 1;
  }
  const Image image = render_image(d);
  check_mean(statistics_of(image, 0), value);
  check_mean(statistics_of(image, 3), alpha);
}

TEST_SUITE_END();

}  // namespace sheaf::test_direct_light
