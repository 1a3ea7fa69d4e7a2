// Strict reading: all errors of a scene at once, with places, elements and codes.
#include "scene/description/error_sink.h"
#include "tests/support/files/scene_files.h"

#include <doctest/doctest.h>

#include <fmt/format.h>

namespace sheaf::test_strict {

using namespace test;

namespace {

using Code = SceneErrorCode;

struct Expected {
  int line;
  Code code;
  const char* element;
};

void check_errors(const std::string& text, const std::vector<Expected>& expected) {
  const std::vector<SceneError> errors = errors_of_text(text);
  REQUIRE(errors.size() == expected.size());
  for (std::size_t i = 0; i < errors.size(); ++i) {
    CAPTURE(std::string(errors[i].what()));
    CHECK(std::filesystem::path(errors[i].where().file.string()).filename() == "scene.xml");
    CHECK(errors[i].where().line == expected[i].line);
    CHECK(errors[i].code() == expected[i].code);
    CHECK(errors[i].element() == expected[i].element);
  }
}

}  // namespace

TEST_CASE("error sink: strict errors are thrown together, lenient ones become messages") {
  std::vector<std::string> substitutions;
  const SceneError first({"a.xml", 3}, "first"), second({"a.xml", 2}, "second", Code::kMissing);
  {
    ErrorSink errors(true, substitutions);
    errors.run([&] {
      errors.report(first, "ignored");
      errors.report(second, "gray");
      errors.report(first, "ignored");
    });
    CHECK(substitutions == std::vector<std::string>{"a.xml:3: first (ignored)", "a.xml:2: second (gray)"});
    CHECK_THROWS_AS(errors.run([&] { throw first; }), SceneError);
  }
  ErrorSink errors(false, substitutions);
  CHECK_NOTHROW(errors.throw_errors());
  CHECK_THROWS_WITH_AS(errors.run([&] { throw second; }), "a.xml:2: second", SceneError);
  errors.report(first, "ignored");
  try {
    errors.run([&] { throw second; });
    FAIL("no error");
  } catch (const SceneErrors& all) {
    CHECK(std::string(all.what()) == "a.xml:3: first\na.xml:2: second");
    CHECK(all.all().size() == 2);
    CHECK(all.where() == SourceLocation{"a.xml", 3});
    CHECK(all.code() == Code::kInvalid);
  }
  CHECK(substitutions.size() == 2);
}

TEST_CASE("strict: all errors of a scene are reported in the order in which it is read") {
  check_errors(
      mitsuba_scene("<shape type='sphere'><float name='radius' value='-1'/>\n"
                    "<float name='size' value='1'/>\n"
                    "<bsdf type='diffus'/></shape>\n"
                    "<shape type='obj'><string name='filename' value='gone.obj'/></shape>\n"
                    "<shape type='cube'><bsdf type='plastic'>\n"
                    "<texture name='diffuse_reflectance' type='bitmap'/>\n"
                    "<float name='int_ior' value='x'/></bsdf></shape>\n"
                    "<emitter type='laser'/>\n"
                    "<wizard/>",
                    "<sensor type='perspective'><film type='hdrfilm'><integer name='width' value='1.5'/></film>"
                    "</sensor>"),
      {{4, Code::kOutOfRange, "property 'radius' of shape 'sphere'"},
       {6, Code::kUnknownName, "bsdf 'diffus'"},
       {5, Code::kUnknownName, "property 'size' of shape 'sphere'"},
       {7, Code::kMissingFile, "<shape>"},
       {10, Code::kWrongType, "property 'int_ior' of bsdf 'plastic'"},
       {9, Code::kMissing, "texture 'bitmap'"},
       {11, Code::kUnknownName, "emitter 'laser'"},
       {12, Code::kUnknownName, "<wizard>"},
       {2, Code::kWrongType, "property 'width' of film 'hdrfilm'"}});
}

TEST_CASE("strict: XML is checked before elements, and a missing include is reported alone") {
  check_errors(mitsuba_scene("<shape type='cube' type='sphere'/>\ntext\n<shape type='cone'/>"),
               {{4, Code::kDuplicate, "<shape>"}, {5, Code::kSyntax, "<scene>"}});
  check_errors(mitsuba_scene("<include filename='gone.xml'/>\n<shape type='cube'><ref id='inside'/></shape>"),
               {{4, Code::kMissingFile, ""}});
}

TEST_CASE("strict: unknown plugins cause no errors about their properties") {
  check_errors(mitsuba_scene("<shape type='cube'/>", "<sensor type='fisheye'><float name='bulge' value='2'/></sensor>",
                             "<integrator type='magic'><float name='wand' value='1'/></integrator>"),
               {{2, Code::kUnknownName, "sensor 'fisheye'"}, {3, Code::kUnknownName, "integrator 'magic'"}});
}

TEST_CASE("strict: reading stops after 20 errors") {
  std::string shapes;
  for (int i = 0; i < 30; ++i)
    shapes += fmt::format("<shape type='sphere'><float name='radius' value='-{}'/></shape>\n", i);
  const std::vector<SceneError> errors = errors_of_text(mitsuba_scene(shapes));
  REQUIRE(errors.size() == ErrorSink::kMaxErrors);
  for (std::size_t i = 0; i < errors.size(); ++i) CHECK(errors[i].where().line == static_cast<int>(i) + 4);
}

TEST_CASE("strict: pbrt scenes report all errors of lights and shapes and unsupported features") {
  const TemporaryFolder folder;
  const auto file = write_below(folder, "scene.pbrt",
                                "WorldBegin\n"
                                "LightSource \"laser\"\n"
                                "Shape \"sphere\" \"float radius\" [ 1 2 ]\n"
                                "Shape \"sphere\" \"float bulge\" 2\n"
                                "Shape \"plymesh\" \"string filename\" \"gone.ply\"\n");
  try {
    read_scene(file);
    FAIL("no error");
  } catch (const SceneErrors& errors) {
    CAPTURE(std::string(errors.what()));
    std::vector<std::pair<int, Code>> found;
    for (const SceneError& error : errors.all()) found.emplace_back(error.where().line, error.code());
    CHECK(found ==
          std::vector<std::pair<int, Code>>{
              {2, Code::kUnknownName}, {3, Code::kWrongType}, {4, Code::kUnknownName}, {5, Code::kMissingFile}});
  }
}

}  // namespace sheaf::test_strict
