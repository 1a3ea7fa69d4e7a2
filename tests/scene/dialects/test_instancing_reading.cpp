// Instances of shape groups in scene files.
#include "tests/support/files/scene_files.h"

#include <doctest/doctest.h>

namespace sheaf::test_instancing_reading {

namespace {

const std::string kGroup =
    "<shape type='shapegroup' id='g'><shape type='sphere'><float name='radius' value='2'/></shape>"
    "<shape type='ply'><string name='filename' value='mesh.ply'/><boolean name='face_normals' value='true'/>"
    "<boolean name='flip_normals' value='true'/></shape></shape>\n";
const std::string kPlacedInstance =
    "<shape type='instance'><ref id='g'/><transform name='to_world'><scale x='2'/>"
    "<translate y='3'/></transform></shape>\n";

}  // namespace

TEST_CASE("instancing: Mitsuba scenes may define a group before or after its instances") {
  for (const std::string& text :
       {kGroup + kPlacedInstance + kPlacedInstance, kPlacedInstance + kPlacedInstance + kGroup}) {
    const Description d = test::read_text(test::mitsuba_scene(text + "<shape type='cube'/>"));
    REQUIRE(d.shapes.size() == 1);
    REQUIRE(d.groups.size() == 1);
    CHECK(d.groups[0].id == "g");
    REQUIRE(d.groups[0].shapes.size() == 2);
    CHECK(std::get<SphereShape>(d.groups[0].shapes[0].geometry).radius == 2);
    CHECK(d.groups[0].shapes[1].face_normals);
    CHECK(d.groups[0].shapes[1].flip_normals);
    REQUIRE(d.instances.size() == 2);
    CHECK(d.instances[0].group == 0);
    CHECK(d.instances[1].to_world == std::array<double, 12>{2, 0, 0, 0, 0, 1, 0, 3, 0, 0, 1, 0});
  }
  const Description nested = test::read_text(
      test::mitsuba_scene("<shape type='instance'><shape type='shapegroup'><shape type='sphere'/></shape></shape>"));
  CHECK(nested.groups.size() == 1);
  CHECK(nested.instances.size() == 1);
  CHECK(nested.shapes.empty());
}

TEST_CASE("instancing: Nori scenes are read") {
  const Description d = test::read_text(
      "<scene><camera type='perspective'/><integrator type='normals'/>"
      "<mesh type='shapegroup' id='g'><mesh type='sphere'><bsdf type='mirror'/></mesh></mesh>"
      "<mesh type='instance'><ref id='g'/><transform name='toWorld'>"
      "<translate value='1,2,3'/></transform></mesh></scene>");
  CHECK(d.shapes.empty());
  REQUIRE(d.groups.size() == 1);
  REQUIRE(d.groups[0].shapes.size() == 1);
  CHECK(d.groups[0].shapes[0].material.has_value());
  REQUIRE(d.instances.size() == 1);
  CHECK(d.instances[0].to_world == std::array<double, 12>{1, 0, 0, 1, 0, 1, 0, 2, 0, 0, 1, 3});
}

TEST_CASE("instancing: errors include the line") {
  const auto message = [](const std::string& inside) { return test::error_of_text(test::mitsuba_scene(inside)); };
  const std::string group = "<shape type='shapegroup' id='g'><shape type='sphere'/></shape>\n";
  const std::string tests[][2] = {
      {"<shape type='instance'/>", "scene.xml:4: shape 'instance' needs a <ref> to a shapegroup"},
      {group + "<shape type='instance'><ref id='h'/></shape>", "scene.xml:5: no object has the id 'h'"},
      {"<shape type='sphere' id='s'/>\n<shape type='instance'><ref id='s'/></shape>",
       "scene.xml:5: shape 'instance' refers to a 'sphere', expected a 'shapegroup'"},
      {group + "<shape type='instance'><ref id='g'/><ref id='g'/></shape>",
       "scene.xml:5: shape 'instance' has 2 nested"},
      {group + "<shape type='instance'><ref id='g'/>\n<bsdf type='diffuse'/></shape>",
       "scene.xml:6: shape 'instance' takes no nested <bsdf>"},
      {group + "<shape type='instance'><ref id='g'/><boolean name='flip_normals' value='true'/></shape>",
       "scene.xml:5: unknown property 'flip_normals' of shape 'instance'"},
      {group + "<shape type='instance'><ref id='g'/>\n<transform name='to_world'>"
               "<scale value='1e-12'/></transform></shape>",
       "scene.xml:6: property 'to_world' of shape 'instance' is singular or too extreme"},
      {group + "<shape type='shapegroup' id='h'>\n<shape type='instance'><ref id='g'/></shape></shape>",
       "scene.xml:6: 'instance' inside a shape group"},
      {"<shape type='shapegroup'>\n<shape type='shapegroup'/></shape>",
       "scene.xml:5: 'shapegroup' inside a shape group"},
      {"<shape type='shapegroup' id='g'>\n<ref id='g'/></shape>", "scene.xml:4: 'shapegroup' inside a shape group"},
      {"<shape type='shapegroup'><bsdf type='diffuse'/></shape>", "takes no nested <bsdf>"},
  };
  for (const auto& [inside, expected] : tests) {
    const std::string found = message(inside);
    INFO(found);
    CHECK(test::contains(found, expected));
  }
}

}  // namespace sheaf::test_instancing_reading
