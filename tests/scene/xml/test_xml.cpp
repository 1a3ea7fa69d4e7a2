// The XML layer: syntax errors with lines, hostile files, and the elements include, default, path, alias and $name.
#include "scene/xml/xml_expand.h"
#include "scene/xml/xml_values.h"
#include "tests/support/files/scene_files.h"

#include <doctest/doctest.h>

namespace sheaf::test_xml {

using namespace test;

namespace {

/// A complete scene around `inside`.
std::string scene_with(const std::string& inside) {
  return "<scene version=\"3.0.0\">\n<sensor type=\"perspective\"/><integrator type=\"path\"/>\n" + inside +
         "\n</scene>\n";
}

}  // namespace

TEST_CASE("XML: malformed files are errors with a line number") {
  struct Case {
    const char* text;
    const char* expected;
  };
  const Case cases[] = {
      {"", "scene.xml:1: the file has no XML element"},
      {"   \n\n", "scene.xml:1: the file has no XML element"},
      {"not xml at all", "scene.xml:1: the file has no XML element"},
      {"<scene>\n<bsdf>\n", "scene.xml:2: not well-formed XML"},
      {"<scene>\n<bsdf type='x>\n</scene>", "scene.xml:2: not well-formed XML"},
      {"<scene>\n</bsdf>\n</scene>", "scene.xml:2: not well-formed XML"},
      {"<scene>\n<!-- never closed\n", "not well-formed XML"},
      {"<scene a='1' a='2'/>", "scene.xml:1: attribute 'a' is set twice"},
      {"<scene/>\n<scene/>", "scene.xml:2: a second root element <scene>"},
      {"<scene version='3.0.0'>\n\nhello\n</scene>", "scene.xml:3: unexpected text 'hello' inside <scene>"},
      {"<shape/>", "scene.xml:1: root element is <shape>, expected <scene>"},
  };
  for (const Case& c : cases) {
    CAPTURE(std::string(c.text));
    const std::string message = error_of_text(c.text);
    CHECK_MESSAGE(contains(message, c.expected), message);
  }
}

TEST_CASE("XML: the lines of elements follow values and text of several lines") {
  std::vector<std::string> substitutions;
  ErrorSink errors(true, substitutions);
  const TemporaryFolder folder;
  const XmlElement root = read_xml(write_below(folder, "lines.xml",
                                               "<scene\n>\n<a x='$(1 +\n2)' y='$(3)'\n z='$(4)'/><b/>\n\n<c>\n\n"
                                               "text\n<d/></c>\n<!--\n--><e x='$(5)'/>\n</scene>"),
                                   errors);
  REQUIRE(root.children.size() == 4);
  const XmlElement &a = root.children[0], &b = root.children[1], &c = root.children[2], &e = root.children[3];
  CHECK(root.where.line == 1);
  CHECK(a.where.line == 3);
  CHECK(a.attributes[0].line == 0);
  CHECK(a.attributes[1].line == 4);
  CHECK(a.attributes[1].column == 8);
  CHECK(a.attributes[2].line == 5);
  CHECK(b.where.line == 5);
  CHECK(c.where.line == 7);
  CHECK(c.children.at(0).where.line == 10);
  CHECK(e.where.line == 12);
  CHECK(e.attributes[0].line == 12);
  CHECK(e.attributes[0].column == 10);
  REQUIRE(substitutions.size() == 1);
  CHECK(contains(substitutions[0], "lines.xml:9: unexpected text 'text'"));
}

TEST_CASE("XML: entities of a DTD are not expanded") {
  const std::string text =
      "<!DOCTYPE scene [<!ENTITY a \"aaaaaaaaaa\"><!ENTITY b \"&a;&a;&a;&a;\">]>\n<scene version=\"&b;\"/>";
  const TemporaryFolder folder;
  std::vector<std::string> substitutions;
  ErrorSink errors(false, substitutions);
  CHECK(read_xml(write_below(folder, "entities.xml", text), errors).attribute("version") == "&b;");
}

TEST_CASE("XML: hostile files are errors") {
  SUBCASE("truncated anywhere") {
    const std::string whole = scene_with("<shape type=\"sphere\"><float name=\"radius\" value=\"2\"/></shape>");
    REQUIRE(error_of_text(whole).empty());
    for (std::size_t length = 0; length + 3 < whole.size(); ++length) {
      CAPTURE(length);
      CHECK(contains(error_of_text(whole.substr(0, length)), "scene.xml:"));
    }
  }
  SUBCASE("100 000 levels") {
    std::string text;
    for (int i = 0; i < 100'000; ++i) text += "<scene>";
    for (int i = 0; i < 100'000; ++i) text += "</scene>";
    CHECK(contains(error_of_text(text), "nested deeper than 100 levels"));
  }
  SUBCASE("unclosed levels") {
    std::string text;
    for (int i = 0; i < 100'000; ++i) text += "<scene>";
    CHECK(contains(error_of_text(text), "not well-formed"));
  }
  SUBCASE("an attribute of 10 MB gives a short message") {
    const std::string huge(10'000'000, 'x');
    const std::string as_value =
        error_of_text(scene_with("<shape type=\"sphere\"><float name=\"radius\" value=\"" + huge + "\"/></shape>"));
    CHECK(contains(as_value, "scene.xml:3: property 'radius'"));
    CHECK(as_value.size() < 1000);
    const std::string as_type = error_of_text(scene_with("<shape type=\"" + huge + "\"/>"));
    CHECK(contains(as_type, "unknown shape plugin"));
    CHECK(as_type.size() < 1000);
    CHECK(error_of_text(scene_with("<bsdf type=\"diffuse\" id=\"" + huge + "\"/>")).empty());
    const std::string as_file =
        error_of_text(scene_with("<shape type=\"obj\"><string name=\"filename\" value=\"" + huge + "\"/></shape>"));
    CHECK(contains(as_file, "not found"));
    CHECK(as_file.size() < 1000);
  }
  SUBCASE("bytes that are not text") {
    std::string bytes = scene_with("<shape type=\"sphere\"/>");
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      for (char replacement : {'\0', '\xff', '<', '"', '$'}) {
        std::string mutated = bytes;
        mutated[i] = replacement;
        CAPTURE(i);
        const std::string message = error_of_text(mutated);
        CHECK((message.empty() || contains(message, "scene.xml")));
      }
    }
  }
  SUBCASE("too many attributes") {
    std::string text = "<scene ";
    for (int i = 0; i < 1000; ++i) text += "a" + std::to_string(i) + "='' ";
    CHECK(contains(error_of_text(text + "/>"), "more than 64 attributes"));
  }
}

TEST_CASE("XML: unreadable files are errors") {
  const TemporaryFolder folder;
  CHECK(contains(error_of(folder / "absent.xml"), "absent.xml: file not found"));
  CHECK(contains(error_of(folder.path()), "not a regular file"));
}

TEST_CASE("expansion: parameters") {
  const std::string text = scene_with(
      "<default name=\"r\" value=\"2\"/><default name=\"twice\" value=\"$r$r\"/>\n"
      "<shape type=\"sphere\"><float name=\"radius\" value=\"$twice.5\"/></shape>");
  auto define = [](const char* name, const char* value) {
    ReadOptions options;
    options.defines = {{name, value}};
    return options;
  };
  auto radius = [&](const ReadOptions& options) {
    return std::get<SphereShape>(read_text(text, options).shapes.at(0).geometry).radius;
  };
  CHECK(radius({}) == 22.5f);
  CHECK(radius(define("r", "3")) == 33.5f);
  CHECK(radius(define("twice", "7")) == 7.5f);
  CHECK(contains(error_of_text(text, define("twic", "7")), "no parameter 'twic' for -D to set, did you mean 'twice'?"));
  CHECK(contains(error_of_text(scene_with("<shape type=\"$shap\"/><default name=\"shape\" value=\"obj\"/>")),
                 "scene.xml:3: parameter '$shap' is not defined"));
  CHECK(contains(error_of_text(scene_with("<default name=\"shape\" value=\"obj\"/><shape type=\"$shap\"/>")),
                 "did you mean 'shape'?"));
  CHECK(contains(error_of_text(scene_with("<default name=\"a b\" value=\"\"/>")), "'a b' is not a parameter name"));
  CHECK(contains(error_of_text(scene_with("<default nam=\"a\" value=\"\"/>")), "has no attribute 'nam'"));
}

TEST_CASE("expansion: exponentially growing parameters are stopped") {
  std::string text = "<default name=\"p0\" value=\"xxxxxxxxxxxxxxxx\"/>";
  for (int i = 1; i < 40; ++i)
    text += "<default name=\"p" + std::to_string(i) + "\" value=\"$p" + std::to_string(i - 1) + " $p" +
            std::to_string(i - 1) + "\"/>";
  CHECK(contains(error_of_text(scene_with(text)), "the default value is longer than 1 MiB"));
}

TEST_CASE("expansion: includes") {
  const TemporaryFolder folder;
  SUBCASE("included elements replace the include and files are searched in three places") {
    write_below(folder, "parts/light.xml",
                "<scene version='3.0.0'><default name='radius' value='3'/><include filename='light2.xml'/>"
                "<include filename='parts/light3.xml'/></scene>");
    write_below(folder, "parts/light2.xml", "<scene version='3.0.0'><emitter type='constant'/></scene>");
    write_below(folder, "parts/light3.xml", "<emitter type='point'/>");
    write_below(folder, "elsewhere/ball.xml",
                "<scene version='3.0.0'><shape type='sphere'><float name='radius' value='$radius'/></shape></scene>");
    const Description d = read_scene(write_below(
        folder, "scene.xml",
        scene_with("<path value='elsewhere'/><include filename='parts/light.xml'/><include filename='ball.xml'/>")));
    CHECK(d.lights.size() == 2);
    REQUIRE(d.shapes.size() == 1);
    CHECK(std::get<SphereShape>(d.shapes[0].geometry).radius == 3);
  }
  SUBCASE("the path declared last is searched first and the folder of the scene file after all paths") {
    for (const char* name : {"part.xml", "a/part.xml", "b/part.xml"})
      write_below(folder, name, std::string("<scene><bsdf type='diffuse' id='") + name + "'/></scene>");
    const Description d = read_scene(write_below(
        folder, "scene.xml", scene_with("<path value='a'/><path value='b'/><include filename='part.xml'/>")));
    CHECK(d.materials.at(0).id == "b/part.xml");
  }
  SUBCASE("errors name the included file and its line") {
    write_below(folder, "part.xml", "<scene version='3.0.0'>\n\n<shape type='spere'/></scene>");
    const auto file = write_below(folder, "scene.xml", scene_with("<include filename='part.xml'/>"));
    CHECK(contains(error_of(file), "part.xml:3: unknown shape plugin 'spere', did you mean 'sphere'? (known: "));
  }
  SUBCASE("a file that includes itself") {
    const auto file = write_below(folder, "scene.xml", scene_with("<include filename='scene.xml'/>"));
    CHECK(contains(error_of(file), "scene.xml:3: includes are nested deeper than 15 levels"));
  }
  SUBCASE("many includes in many includes") {
    std::string inside;
    for (int i = 0; i < 30; ++i) inside += "<include filename='empty.xml'/>";
    std::string next = "empty.xml";
    write_below(folder, next, "<scene version='3.0.0'/>");
    for (int level = 0; level < 8; ++level) {
      std::string text;
      for (int i = 0; i < 30; ++i) text += "<include filename='" + next + "'/>";
      next = "level" + std::to_string(level) + ".xml";
      write_below(folder, next, "<scene version='3.0.0'>" + text + "</scene>");
    }
    const auto file = write_below(folder, "scene.xml", scene_with("<include filename='" + next + "'/>"));
    CHECK(contains(error_of(file), "more than 10000 includes"));
  }
  SUBCASE("a missing file") {
    const auto file = write_below(folder, "scene.xml", scene_with("<include filename='gone.xml'/>"));
    CHECK(contains(error_of(file), "scene.xml:3: file 'gone.xml' not found in "));
    const auto other = write_below(folder, "scene.xml", scene_with("<path value='gone'/>"));
    CHECK(contains(error_of(other), "scene.xml:3: file 'gone' not found in "));
  }
}

TEST_CASE("expansion: ids and references and aliases are resolved") {
  auto shapes = [](const std::string& inside) { return read_text(scene_with(inside)).shapes; };
  CHECK(shapes("<shape type='sphere'><ref id='b'/></shape><bsdf type='diffuse' id='a'/><alias id='a' as='b'/>")
            .at(0)
            .material.has_value());
  struct Case {
    const char* inside;
    const char* expected;
  };
  const Case cases[] = {
      {"<bsdf type='diffuse' id='a'/>\n<bsdf type='diffuse' id='a'/>",
       "scene.xml:4: id 'a' is already taken by <bsdf>"},
      {"<bsdf type='diffuse' id='red'/>\n<shape type='sphere'><ref id='rad'/></shape>",
       "scene.xml:4: no object has the id 'rad', did you mean 'red'?"},
      {"<bsdf type='diffuse' id='red'/><alias id='rad' as='x'/>", "no object has the id 'rad'"},
      {"<bsdf type='diffuse' id='a'/><bsdf type='diffuse' id='b'/><alias id='a' as='b'/>", "id 'b' is already taken"},
      {"<bsdf type='twosided' id='a'><ref id='a'/></bsdf>", "scene.xml:3: bsdf 'twosided' refers to itself"},
      {"<bsdf type='twosided' id='a'><ref id='b'/></bsdf>\n<bsdf type='twosided' id='b'><ref id='a'/></bsdf>",
       "bsdf 'twosided' refers to itself"},
      {"<shape type='sphere'><ref/></shape>", "scene.xml:3: <ref> needs an attribute 'id'"},
      {"<bsdf type='diffuse' id='a'/><ref id='a'/>", "scene.xml:3: <ref> at the top level"},
  };
  for (const Case& c : cases) {
    CAPTURE(std::string(c.inside));
    const std::string message = error_of_text(scene_with(c.inside));
    CHECK_MESSAGE(contains(message, c.expected), message);
  }
}

TEST_CASE("expansion: a long chain of references does not exhaust the stack") {
  std::string text = "<bsdf type='diffuse' id='m0'/>";
  for (int i = 50'000; i > 0; --i)
    text += "<bsdf type='twosided' id='m" + std::to_string(i) + "'><ref id='m" + std::to_string(i - 1) + "'/></bsdf>";
  CHECK(contains(error_of_text(scene_with(text)), "nested deeper than 100 references"));
}

TEST_CASE("values: numbers and booleans and vectors are parsed") {
  const SourceLocation where{"f", 1};
  CHECK(parse_float(" +1.5e3 ", where, "x") == 1500.0f);
  CHECK(parse_float("-.5", where, "x") == -0.5f);
  CHECK(parse_integer("-12", where, "x") == -12);
  CHECK(parse_integer("64.0", where, "x") == 64);
  CHECK(parse_integer("1e6", where, "x") == 1'000'000);
  CHECK(parse_integer("-2.5e1", where, "x") == -25);
  CHECK(parse_integer("9223372036854775807", where, "x") == 9223372036854775807);
  CHECK(parse_boolean("True", where, "x"));
  CHECK_FALSE(parse_boolean("false", where, "x"));
  CHECK(parse_floats("1, 2 3,,4\n5", where, "x") == std::vector<float>{1, 2, 3, 4, 5});
  for (const char* bad : {"", "abc", "1x", "nan", "inf", "1e39", "1e999", "1 2", "0x10", "+-1", "1,5"}) {
    CAPTURE(std::string(bad));
    CHECK_THROWS_AS(parse_float(bad, where, "x"), SceneError);
  }
  for (const char* bad : {"", "1.5", "99999999999999999999", "1e-3", "1e17", "1e999", "nan", "inf", "1.0x", "one"}) {
    CAPTURE(std::string(bad));
    CHECK_THROWS_AS(parse_integer(bad, where, "x"), SceneError);
  }
  CHECK_THROWS_AS(parse_boolean("1", where, "x"), SceneError);
  CHECK_THROWS_AS(parse_boolean("truefalse", where, "x"), SceneError);
}

}  // namespace sheaf::test_xml
