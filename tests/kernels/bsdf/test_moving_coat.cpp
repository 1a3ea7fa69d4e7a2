// The coat over the emission of a lamp that turns: light sampling uses the normal at the time of the path.
#include "scene/compile/compile.h"
#include "tests/support/light_testing.h"
#include "tests/support/motion_testing.h"
#include "tests/support/near.h"
#include "tests/support/tiny_scenes.h"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

namespace sheaf::test_moving_coat {

TEST_CASE("moving coats: the radiance of samples follows the angle at the turned lamp") {
  constexpr double kAngle = 70;
  Description d = empty_scene(1, 1);
  ShapeDescription& lamp = add_shape(d, RectangleShape{}, Transform());
  lamp.radiance = SpectrumDescription::constant(1);
  lamp.emission_coat = 1.0f;
  lamp.motion = add_motion(d, {{0, Transform()}, {1, Transform::rotate({1, 0, 0}, kAngle)}});
  expose(d, 0, 1);
  const auto scene = compile_scene(d);
  const auto radiance_at = [&](float time) {
    const Vec3f from{0, 0, 1000};
    const LightChoice<Scalar> choice = choose_light<Scalar>(scene->view(), {from, {}}, 0.5f);
    const LightSample<Scalar> s =
        sample_light<Scalar>(scene->view(), {from, {}}, choice, {0.5f, 0.3f, 0.6f, 0.5f}, time);
    REQUIRE(s.valid);
    return s.radiance.c0;
  };
  // Schlick's approximation with a reflectance of 0.04 at normal incidence (KHR_materials_clearcoat)
  const auto expected = [](double degrees) {
    return 0.96 * (1 - std::pow(1 - std::cos(degrees * std::numbers::pi / 180), 5));
  };
  CHECK(radiance_at(0) == near(expected(0), 1e-3));
  CHECK(radiance_at(1) == near(expected(kAngle), 5e-3));
}

}  // namespace sheaf::test_moving_coat
