// Shutters of pbrt's cameras: times in the wrong order, and equal times.
#include "scene/compile/compile.h"
#include "scene/xml/named_values.h"
#include "tests/support/pbrt_testing.h"

#include <doctest/doctest.h>

namespace sheaf::test_pbrt_shutter {

using namespace test;

namespace {

Description read(const std::string& shutter) {
  return read_pbrt_world("LightSource \"infinite\" \"rgb L\" [ 1 1 1 ]", "Camera \"spherical\" " + shutter);
}

/// The radiance of the light, which the exposure multiplies.
float exposure_of(const Description& d) {
  return rgb_of(std::get<ConstantLightDescription>(d.lights.at(0).model).radiance).x;
}

}  // namespace

TEST_CASE("pbrt: a shutter that closes before it opens is exchanged, with a warning") {
  struct Case {
    const char* parameters;
    double open, close;
  };
  const Case cases[] = {
      {"\"float shutteropen\" 1 \"float shutterclose\" 0", 0, 1},
      {"\"float shutterclose\" -0.5 \"float shutteropen\" 3.5", -0.5, 3.5},
      {"\"float shutteropen\" 2", 1, 2},
      {"\"float shutterclose\" -2", -2, 0},
  };
  for (const Case& each : cases) {
    CAPTURE(each.parameters);
    const Description d = read(each.parameters);
    CHECK(d.shutter.open == each.open);
    CHECK(d.shutter.close == each.close);
    CHECK(exposure_of(d) == static_cast<float>(each.close - each.open));
    REQUIRE(d.warnings.size() == 1);
    CHECK(contains(d.warnings[0], "scene.pbrt:1: Camera: 'shutteropen' " + number_text(each.close) +
                                      " is later than 'shutterclose' " + number_text(each.open) + ": exchanged"));
    CHECK(d.notes.empty());
    // Compiled scenes have the warning, which `render` and `info` print
    CHECK(compile_scene(d, {})->warnings() == d.warnings);
  }
  CHECK(read("\"float shutteropen\" 0.25 \"float shutterclose\" 0.5").warnings.empty());
}

TEST_CASE("pbrt: a shutter that opens and closes at one time makes a still") {
  const Description d = read("\"float shutteropen\" 1");
  CHECK(d.shutter.open == 1);
  CHECK(d.shutter.close == 1);
  CHECK(exposure_of(d) == 1);
  CHECK(d.warnings.empty());
  REQUIRE(d.notes.size() == 1);
  CHECK(contains(d.notes[0], "opens and closes at 1: a still without motion blur"));
}

}  // namespace sheaf::test_pbrt_shutter
