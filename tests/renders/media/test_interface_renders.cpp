// Glass slabs, single interfaces, mirrors and metals against the Fresnel equations, and materials of each side.
#include "tests/renders/light/closed_forms.h"
#include "tests/support/capture.h"

#include <doctest/doctest.h>

#include <cmath>
#include <complex>
#include <functional>
#include <optional>
#include <utility>

namespace sheaf::test_interface_renders {

using namespace closed_forms;

namespace {

/// Reflectance of an interface; `eta` may be complex (far side over near side).
double fresnel(double cos_incident, std::complex<double> eta) {
  const std::complex<double> cos_far = std::sqrt(1.0 - (1 - cos_incident * cos_incident) / (eta * eta));
  const auto s = (cos_incident - eta * cos_far) / (cos_incident + eta * cos_far);
  const auto p = (eta * cos_incident - cos_far) / (eta * cos_incident + cos_far);
  return 0.5 * (std::norm(s) + std::norm(p));
}

}  // namespace

TEST_SUITE_BEGIN("slow");

TEST_CASE("a glass slab in front of a light has the closed-form transmittance") {
  for (const double cosine : {1.0, 0.6}) {
    CAPTURE(cosine);
    Description d = small_scene();
    add_shape(d, CubeShape{}, Transform::scale({20, 20, 0.1f}), add_glass(d));
    add_area_light_rectangle(d, Transform::translate({0, 0, -3}) * Transform::scale({100, 100, 1}), 2);
    aim(d, {static_cast<float>(5 * std::sqrt(1 - cosine * cosine)), 0, static_cast<float>(5 * cosine)}, {0, 0, 0},
        {0, 1, 0});
    const double r = fresnel(cosine, 1.5), t = (1 - r) * (1 - r);
    for (const auto& [depth, expected] :
         {std::pair{2, 0.0}, {3, 2 * t}, {5, 2 * t * (1 + r * r)}, {-1, 2 * (1 - r) / (1 + r)}}) {
      CAPTURE_BINDING(depth);
      d.integrator.max_depth = depth;
      check_strategies(d, expected);
    }
  }
}

TEST_CASE("an interface scales radiance by the squared index and matched indices change nothing") {
  Description d = small_scene();
  add_area_light_rectangle(d, Transform::translate({0, 0, -3}) * Transform::scale({100, 100, 1}), 2);
  aim(d, {3, 0, 4}, {0, 0, 0}, {0, 1, 0});
  const Transform large = Transform::scale({50, 50, 1});
  SUBCASE("from air into glass") {
    add_rectangle(d, large, add_glass(d));
    check_strategies(d, 2 * (1 - fresnel(0.8, 1.5)) / (1.5 * 1.5));
  }
  SUBCASE("from glass into air") {
    add_rectangle(d, large, add_glass(d, 1, 1.2f));
    check_strategies(d, 2 * (1 - fresnel(0.8, 1 / 1.2)) * (1.2 * 1.2));
  }
  SUBCASE("matched") {
    add_sphere(d, {0, 0, 0}, 1, add_glass(d, 1.4f, 1.4f));
    check_strategies(d, 2);
  }
}

TEST_CASE("mirrors and metals reflect by their reflectance") {
  Description d = small_scene();
  add_area_light_rectangle(
      d, Transform::translate({-4, 0, 4}) * Transform::rotate({0, 1, 0}, 135) * Transform::scale({3, 3, 1}), 2);
  aim(d, {3, 0, 3}, {0, 0, 0});
  SUBCASE("mirror") {
    add_rectangle(d, Transform::scale({5, 5, 1}), add_mirror(d, 0.8f));
    check_strategies(d, 1.6);
  }
  SUBCASE("metal") {
    using S = SpectrumDescription;
    const ConductorDescription metal{ConductorDescription::Ior{S::constant(0.2f), S::constant(3.9f)}, S::constant(0.9f),
                                     std::nullopt};
    add_rectangle(d, Transform::scale({5, 5, 1}), add_material(d, metal));
    check_strategies(d, 2 * 0.9 * fresnel(std::sqrt(0.5), {0.2, 3.9}));
  }
  SUBCASE("mirror from behind") {
    add_rectangle(d, Transform::rotate({1, 0, 0}, 180) * Transform::scale({5, 5, 1}), add_mirror(d));
    check_strategies(d, 0);
  }
}

TEST_CASE("each side of a surface has its own material") {
  const auto check_sides = [](double front, double back, const std::function<void(Description&)>& add) {
    for (const float side : {1.0f, -1.0f}) {
      CAPTURE(side);
      Description d = small_scene();
      add_constant_light(d, 3);
      aim(d, {1, 0, 2 * side}, {0, 0, 0}, {0, 1, 0});
      add(d);
      check_strategies(d, side > 0 ? front : back);
    }
  };
  SUBCASE("one-sided") {
    check_sides(0.75, 0, [](Description& d) { add_rectangle(d, Transform(), add_diffuse(d, 0.25f)); });
  }
  SUBCASE("the same twice") {
    check_sides(0.75, 0.75,
                [](Description& d) { add_rectangle(d, Transform(), add_two_sided(d, add_diffuse(d, 0.25f))); });
  }
  SUBCASE("different ones") {
    check_sides(0.75, 2.25, [](Description& d) {
      const MaterialId a = add_diffuse(d, 0.25f), b = add_diffuse(d, 0.75f);
      add_rectangle(d, Transform(), add_material(d, TwoSidedDescription{a, b}));
    });
  }
  SUBCASE("one-sided emitter") {
    check_sides(5, 0, [](Description& d) { add_area_light_rectangle(d, Transform(), 5); });
  }
}

TEST_SUITE_END();

}  // namespace sheaf::test_interface_renders
