// Phase functions in scenes of Mitsuba: parameters, mixtures, and errors.
#include "tests/scene/dialects/medium_files.h"
#include "tests/support/near.h"
#include "tests/support/scene_errors.h"

#include <doctest/doctest.h>

#include <array>
#include <string>

namespace sheaf::test_phase_reading {

using namespace test;
using namespace medium_files;

TEST_CASE("media: phase functions of every kind are read") {
  const Description d = read_volumes(
      mitsuba_scene(medium("homogeneous",
                           "<phase type='blendphase'><float name='weight' value='0.25'/><phase type='rayleigh'/>"
                           "<phase type='blendphase'>" +
                               volume("weight", "volcache",
                                      "<integer name='blockSize' value='8'/><volume type='constvolume'>"
                                      "<float name='value' value='1'/></volume>") +
                               "<phase type='isotropic'/><phase type='hg'/></phase></phase>")));
  REQUIRE(only_medium(d).phase);
  REQUIRE(d.phases.size() == 5);
  const auto at = [&](PhaseId id) -> const PhaseDescription& { return d.phases[static_cast<std::size_t>(id)]; };
  const auto& outer = std::get<BlendPhaseDescription>(at(*only_medium(d).phase).model);
  CHECK(outer.weight == 0.25f);
  CHECK(std::holds_alternative<RayleighDescription>(at(outer.nested[0]).model));
  const auto& inner = std::get<BlendPhaseDescription>(at(outer.nested[1]).model);
  CHECK(inner.weight == 1);
  CHECK(std::holds_alternative<IsotropicPhaseDescription>(at(inner.nested[0]).model));
  CHECK(std::get<HenyeyGreensteinDescription>(at(inner.nested[1]).model).g == 0.8f);
}

TEST_CASE("media: microflakes may be constant or a grid") {
  const auto flakes = [](const std::string& inside) -> SggxDescription {
    const Description d =
        read_volumes(mitsuba_scene(medium("homogeneous", "<phase type='sggx'>" + inside + "</phase>")));
    REQUIRE(d.phases.size() == 1);
    return std::get<SggxDescription>(d.phases[0].model);
  };
  const auto numbers = flakes(volume("S", "constvolume", "<string name='value' value='1, 2, 3, 0.1, 0.2, -0.3'/>"));
  CHECK(std::get<std::array<float, 6>>(numbers.matrix) == std::array<float, 6>{1, 2, 3, 0.1f, 0.2f, -0.3f});
  const auto grid =
      flakes(volume("S", "gridvolume", file("a.vol") + "<transform name='to_world'><translate x='2'/></transform>"));
  CHECK(std::get<Grid>(grid.matrix).to_world.point({1, 0, 0}) == Vec3f{3, 0, 0});
}

TEST_CASE("media: mixtures of phase functions become nested blends and constant volumes may have transforms") {
  const Description d = read_text(mitsuba_scene(
      "<medium type='homogeneous'><phase type='mixturephase'><string name='weights' value='0.2, 0.3, 0.5'/>"
      "<phase type='rayleigh'/><phase type='isotropic'/><phase type='hg'/></phase>"
      "<volume name='albedo' type='constvolume'><float name='value' value='0.5'/>"
      "<transform name='to_world'><translate x='1'/></transform></volume></medium>"));
  REQUIRE(d.phases.size() == 5);
  const auto whole = std::get<BlendPhaseDescription>(d.phases.at(4).model);
  CHECK(d.media.at(0).phase == PhaseId{4});
  CHECK(whole.weight == near(0.8));
  CHECK(std::holds_alternative<RayleighDescription>(d.phases.at(static_cast<std::size_t>(whole.nested[0])).model));
  const auto rest = std::get<BlendPhaseDescription>(d.phases.at(static_cast<std::size_t>(whole.nested[1])).model);
  CHECK(rest.weight == near(0.625));
  CHECK(std::holds_alternative<IsotropicPhaseDescription>(d.phases.at(static_cast<std::size_t>(rest.nested[0])).model));
  const auto error = [](const std::string& weights) {
    return error_of_text(
        mitsuba_scene("<medium type='homogeneous'><phase type='mixturephase'>"
                      "<string name='weights' value='" +
                      weights +
                      "'/>"
                      "<phase type='rayleigh'/><phase type='hg'/></phase></medium>"));
  };
  CHECK(contains(error("1"), "has 2 nested <phase> and 1 weights"));
  CHECK(contains(error("0.5, 0.2"), "expected 1"));
  CHECK(contains(error("2, -1"), "a non-negative number"));
  CHECK(error("3, 1").empty());
}

TEST_CASE("media: errors of phase functions in Mitsuba scenes have line and nearest name") {
  const auto tabphase = [](const std::string& inside) {
    return mitsuba_scene(medium("homogeneous", "<phase type='tabphase'>" + inside + "</phase>"));
  };
  const auto phase = [](const std::string& inside) { return mitsuba_scene(medium("homogeneous", "\n" + inside)); };
  check_errors(
      {
          {phase("<phase type='sggx'/>"), "scene.xml:5: phase 'sggx' needs the <volume> 'S'"},
          {phase("<phase type='sggx'>" + volume("S", "constvolume", "<string name='value' value='1 2 3'/>") +
                 "</phase>"),
           "has 3 numbers, expected six: xx yy zz xy xz yz"},
          {phase("<phase type='sggx'>" + volume("S", "constvolume", "<float name='value' value='1'/>") + "</phase>"),
           "given as <float>, expected string"},
          {phase("<phase type='sggx'>" + volume("S", "gridvolume", file("a.nvdb")) + "</phase>"),
           "expected a .vol file"},
          {phase("<phase type='hgg'/>"), "scene.xml:5: unknown phase plugin 'hgg', did you mean 'hg'?"},
          {phase("<phase type='microflake'/>"), "unknown phase plugin 'microflake'"},
          {phase("<phase type='hg'><float name='g' value='1'/></phase>"), "expected a number between -1 and 1"},
          {phase("<phase type='hg'><float name='g' value='-1'/></phase>"), "expected a number between -1 and 1"},
          {phase("<phase type='isotropic'/><phase type='isotropic'/>"), "has 2 nested <phase>, expected one"},
          {phase("<phase type='blendphase'><phase type='hg'/></phase>"), "has 1 nested <phase>, expected two"},
          {phase("<phase type='blendphase'><float name='weight' value='2'/></phase>"), "expected values within [0, 1]"},
          {phase("<phase type='blendphase'>" + volume("weight", "gridvolume", file("a.vol")) + "</phase>"),
           "has a grid for 'weight', expected the same value everywhere"},
          {tabphase(""), "phase 'tabphase' needs the string 'values'"},
          {tabphase("<string name='values' value='1'/>"), "has 1 numbers, expected at least two"},
          {tabphase("<string name='values' value='1, -2, 3'/>"), "has -2, expected a non-negative number"},
          {tabphase("<string name='values' value='0, 0'/>"), "add up to 0, expected more than 0"},
          {tabphase("<string name='values' value='1, x'/>"), "'x'"},
          {mitsuba_scene("<phase type='hg'/>"),
           "<phase> at the top level is not referenced, expected it inside a <medium>"},
      },
      error_of_volumes);
}

}  // namespace sheaf::test_phase_reading
