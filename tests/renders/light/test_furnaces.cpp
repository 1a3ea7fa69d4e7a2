// Furnaces: objects in constant environments, and closed shapes that emit and reflect.
#include "tests/renders/light/closed_forms.h"

#include <doctest/doctest.h>

#include <cmath>

namespace sheaf::test_furnaces {

using namespace closed_forms;

namespace {

/// The sum of the first `terms` powers of `ratio`.
double geometric_sum(double ratio, int terms) { return (1 - std::pow(ratio, terms)) / (1 - ratio); }

}  // namespace

TEST_SUITE_BEGIN("slow");

TEST_CASE("a convex object in a constant environment has the closed-form radiance") {
  Description d = small_scene();
  const MaterialId material = add_diffuse_rgb(d, 0.2f, 0.5f, 0.9f);
  d.lights.push_back({ConstantLightDescription{SpectrumDescription::rgb(3, 2, 1)}, {}});
  aim(d, {5, 4, 3}, {0.1f, 0.2f, 0.1f});
  const auto check_rgb = [&d] {
    for (int i = 0; i < 3; ++i) {
      d.integrator.strategy = kStrategies[i];
      CAPTURE(kStrategyNames[i]);
      const Image image = render_image(d);
      check_mean(statistics_of(image, 0), 0.2 * 3);
      check_mean(statistics_of(image, 1), 0.5 * 2);
      check_mean(statistics_of(image, 2), 0.9 * 1);
    }
  };
  SUBCASE("sphere") { add_sphere(d, {0, 0, 0}, 1, material); }
  SUBCASE("cube") { add_shape(d, CubeShape{}, Transform::rotate({1, 1, 0}, 30), material); }
  check_rgb();
}

TEST_CASE("lossless objects are invisible in a constant environment") {
  Description d = small_scene();
  look_at(d, {0, 0, 3}, {0, 0, 0}, {0, 1, 0}, 45);
  add_constant_light(d, 2);
  SUBCASE("diffuse") { add_sphere(d, {0, 0, 0}, 1, add_diffuse(d, 1)); }
  SUBCASE("mirror") { add_sphere(d, {0, 0, 0}, 1, add_mirror(d)); }
  SUBCASE("glass") { add_sphere(d, {0, 0, 0}, 1, add_glass(d)); }
  SUBCASE("glass cube") { add_shape(d, CubeShape{}, Transform::rotate({1, 2, 3}, 30), add_glass(d, 1.3f)); }
  SUBCASE("a bubble in water") { add_sphere(d, {0, 0, 0}, 1, add_glass(d, 1, 1.33f)); }
  check_strategies(d, 2);
}

TEST_CASE("the radiance inside a closed emissive and reflective shape is a geometric series") {
  Description d = small_scene();
  look_at(d, {0.2f, -0.3f, 0.1f}, {1, 0.4f, 0.3f});
  const auto enclose = [&d](float albedo) {
    ShapeDescription& shape = d.shapes.back();
    shape.material = add_diffuse(d, albedo);
    shape.flip_normals = true;
    emit(shape, 1.5f);
  };
  SUBCASE("sphere with limited depth") {
    add_sphere(d, {0, 0, 0}, 1);
    enclose(0.7f);
    for (int depth : {1, 2, 3, 6}) {
      CAPTURE(depth);
      d.integrator.max_depth = depth;
      check_strategies(d, 1.5 * geometric_sum(0.7, depth));
    }
  }
  SUBCASE("sphere with different start of Russian roulette") {
    add_sphere(d, {0, 0, 0}, 1);
    enclose(0.7f);
    for (int depth : {1, 2, 5, 40}) {
      CAPTURE(depth);
      d.integrator.rr_depth = depth;
      check_strategies(d, 1.5 / 0.3);
    }
  }
  SUBCASE("ellipsoid") {
    add_shape(d, SphereShape{}, Transform::scale({1, 2, 3}));
    enclose(0.5f);
    check_strategies(d, 1.5 / 0.5);
  }
  SUBCASE("box") {
    add_shape(d, CubeShape{}, Transform::scale({1, 2, 1.5f}));
    enclose(0.6f);
    check_strategies(d, 1.5 / 0.4);
  }
}

TEST_CASE("a point light in an integrating sphere matches the closed form") {
  Description d = small_scene();
  look_at(d, {0.2f, -0.3f, 0.1f}, {1, 0.4f, 0.3f});
  add_sphere(d, {0, 0, 0}, 2, add_diffuse(d, 0.75f)).flip_normals = true;
  add_point_light(d, {0, 0, 0}, 8);
  const double first = 0.75 / kPiD * 8 / 4;
  for (int depth : {1, 2, 3, -1}) {
    CAPTURE(depth);
    d.integrator.max_depth = depth;
    check_strategies(d, depth < 0 ? first / 0.25 : first * geometric_sum(0.75, depth - 1), false);
  }
}

TEST_SUITE_END();

}  // namespace sheaf::test_furnaces
