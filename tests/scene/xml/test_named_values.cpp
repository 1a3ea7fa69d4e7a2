// Typed access to named values: one function reads the properties of an XML element and the parameters of a pbrt
// directive.
#include "scene/xml/named_values.h"

#include "scene/dialects/pbrt/reader.h"
#include "scene/xml/properties.h"
#include "tests/support/files/scene_files.h"

#include <doctest/doctest.h>

namespace sheaf::test_named_values {

using namespace test;

namespace {

enum class Wrap { kRepeat, kClamp };
constexpr NameTable<Wrap> kWraps{{{"repeat", Wrap::kRepeat}, {"clamp", Wrap::kClamp}}};

struct Values {
  float radius;
  int count;
  bool flag;
  std::string name;
  Vec3f center;
  Wrap wrap;
};

/// Needs nothing of either dialect.
Values read_values(NamedValues& p) {
  Values values;
  values.radius = p.number("radius", 1, kPositive);
  values.count = p.integer("count", 3, 1, 10);
  values.flag = p.boolean("flag", false);
  values.name = p.string("name", "none");
  values.center = p.vec3("center", {1, 2, 3});
  values.wrap = p.choice("wrap", kWraps, Wrap::kRepeat);
  p.ignore({"comment"});
  return values;
}

/// The values of an XML element, or the message of the error.
std::string read_xml_values(const std::string& properties, Values* values) {
  const TemporaryFolder folder;
  const ExpandedScene scene(
      write_below(folder, "scene.xml", "<scene>\n<shape type='ball'>\n" + properties + "</shape>\n</scene>\n"), {});
  Description description;
  ErrorSink errors(false, description.substitutions);
  ReadContext context{scene, description, description, description.textures, description.materials, description.phases,
                      errors};
  try {
    Properties p(scene.root().children.at(0), context);
    const Values read = read_values(p);
    if (values != nullptr) *values = read;
    p.reject_unused();
    errors.throw_errors();
  } catch (const SceneError& error) { return error.what(); }
  return {};
}

/// The values of a pbrt directive, or the message of the error.
std::string read_pbrt_values(const std::string& parameters, Values* values) {
  Description description;
  ErrorSink errors(false, description.substitutions);
  pbrt::Reader reader{description, errors, {}, {}};
  try {
    pbrt::Tokens tokens(parameters, "scene.pbrt");
    pbrt::Parameters p(reader, "Shape 'ball'", {"scene.pbrt", 1}, pbrt::read_parameters(tokens));
    const Values read = read_values(p);
    if (values != nullptr) *values = read;
    p.reject_unused();
    errors.throw_errors();
  } catch (const SceneError& error) { return error.what(); }
  return {};
}

void check(const Values& values) {
  CHECK(values.radius == 0.5f);
  CHECK(values.count == 4);
  CHECK(values.flag);
  CHECK(values.name == "ball");
  CHECK(values.center == Vec3f{4, 5, 6});
  CHECK(values.wrap == Wrap::kClamp);
}

}  // namespace

TEST_CASE("named values: one function reads XML properties and pbrt parameters") {
  Values values;
  CHECK(read_xml_values("<float name='radius' value='0.5'/><float name='count' value='4.0'/>"
                        "<boolean name='flag' value='true'/><string name='name' value='ball'/>"
                        "<point name='center' value='4, 5, 6'/><string name='wrap' value='clamp'/>"
                        "<integer name='comment' value='7'/>",
                        &values) == "");
  check(values);
  CHECK(read_pbrt_values("\"float radius\" 0.5 \"float count\" 4 \"bool flag\" true \"string name\" \"ball\" "
                         "\"point3 center\" [ 4 5 6 ] \"string wrap\" \"clamp\" \"integer comment\" 7",
                         &values) == "");
  check(values);
  CHECK(read_xml_values("", &values) == "");
  CHECK(values.radius == 1);
  CHECK(read_pbrt_values("", &values) == "");
  CHECK(values.center == Vec3f{1, 2, 3});
}

TEST_CASE("named values: messages are those of either syntax") {
  const auto xml = [](const std::string& properties, const std::string& message) {
    CHECK(contains(read_xml_values(properties, nullptr), "scene.xml:3: " + message));
  };
  const auto pbrt = [](const std::string& parameters, const std::string& message) {
    CHECK(read_pbrt_values(parameters, nullptr) == "scene.pbrt:1: " + message);
  };
  xml("<float name='radius' value='-1'/>", "property 'radius' of shape 'ball' is '-1', expected a positive number");
  pbrt("\"float radius\" -1", "parameter 'radius' of Shape 'ball' is -1, expected a positive number");
  xml("<integer name='count' value='11'/>",
      "property 'count' of shape 'ball' is '11', expected an integer from 1 to 10");
  pbrt("\"integer count\" 11", "parameter 'count' of Shape 'ball' is 11, expected an integer from 1 to 10");
  xml("<string name='wrap' value='clam'/>",
      "property 'wrap' of shape 'ball' is 'clam', expected repeat or clamp, did you mean 'clamp'?");
  pbrt("\"string wrap\" \"clam\"",
       "parameter 'wrap' of Shape 'ball' is 'clam', expected repeat or clamp, did you mean 'clamp'?");
  xml("<float name='radios' value='1'/>", "unknown property 'radios' of shape 'ball', did you mean 'radius'?");
  pbrt("\"float radios\" 1", "unknown parameter 'radios' of Shape 'ball', did you mean 'radius'?");
}

}  // namespace sheaf::test_named_values
