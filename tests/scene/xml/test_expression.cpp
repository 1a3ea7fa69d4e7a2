// Arithmetic in scene files: values, errors with their positions, and its use in XML and pbrt files.
#include "scene/xml/definitions.h"
#include "scene/xml/expression.h"
#include "tests/support/files/scene_files.h"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <map>

namespace sheaf::test_expression {

using namespace test;

namespace {

const std::map<std::string, std::string, std::less<>> kValues = {{"frame", "7"}, {"half", " 0.5 "}, {"text", "abc"},
                                                                 {"plus", "+2"}, {"empty", ""},     {"odd", "1e999"}};

const std::string* value_of(std::string_view name) {
  const auto found = kValues.find(name);
  return found == kValues.end() ? nullptr : &found->second;
}

double evaluate(std::string_view text) { return evaluate_expression(text, value_of); }

/// Position and message of the error of an expression.
std::pair<std::size_t, std::string> error_in(std::string_view text) {
  try {
    evaluate(text);
  } catch (const ExpressionError& error) { return {error.at, error.what()}; }
  return {std::string::npos, ""};
}

std::string repeated(const std::string& text, int times) {
  std::string all;
  for (int i = 0; i < times; ++i) all += text;
  return all;
}

ReadOptions with(const char* name, const char* value) {
  ReadOptions options;
  options.defines = {{name, value}};
  return options;
}

/// A pbrt scene with a sphere, whose radius is in line 3.
std::string pbrt_sphere(const std::string& radius) {
  return "WorldBegin\nShape \"sphere\"\n  \"float radius\" " + radius + "\n";
}

float radius_of(const Description& scene) { return std::get<SphereShape>(scene.shapes.at(0).geometry).radius; }

float pbrt_radius(const std::string& radius, const ReadOptions& options = {}) {
  const TemporaryFolder folder;
  return radius_of(read_scene(write_below(folder, "scene.pbrt", pbrt_sphere(radius)), options));
}

std::string pbrt_error(const std::string& text, const ReadOptions& options = {}) {
  const TemporaryFolder folder;
  return error_of(write_below(folder, "scene.pbrt", text), options);
}

}  // namespace

TEST_CASE("expressions: values follow the rules of arithmetic") {
  struct Case {
    const char* text;
    double value;
  };
  const Case cases[] = {
      {"1", 1},
      {" 1 + 2 * 3 ", 7},
      {"(1 + 2) * 3", 9},
      {"10 - 4 - 3", 3},
      {"24 / 4 / 2", 3},
      {"7 / 2", 3.5},
      {"2 * 7 % 4", 2},
      {"7 % 4", 3},
      {"-1 % 4", 3},
      {"1 % -4", -3},
      {"7.5 % 2", 1.5},
      {"-8 % 4", 0},
      {"-2 * -3", 6},
      {"--2", 2},
      {"+2 - -2", 4},
      {"-(1 + 2)", -3},
      {".5 + 1e2", 100.5},
      {"frame * 36", 252},
      {"half*frame", 3.5},
      {"plus", 2},
      {"sin(0)", 0},
      {"cos(0) + 1", 2},
      {"sin (pi / 2)", 1},
      {"cos(2 * pi * frame / 28)", std::cos(2 * 3.14159265358979323846 * 7 / 28)},
      {"\t1\n+\r1", 2},
  };
  for (const Case& c : cases) {
    CAPTURE(std::string(c.text));
    CHECK(evaluate(c.text) == c.value);
  }
  const std::map<std::string, std::string, std::less<>> own = {{"pi", "3"}};
  CHECK(evaluate_expression("pi", [&](std::string_view name) {
          const auto found = own.find(name);
          return found == own.end() ? nullptr : &found->second;
        }) == 3);
}

TEST_CASE("expressions: errors have a position") {
  struct Case {
    const char* text;
    std::size_t at;
    const char* message;
  };
  const Case cases[] = {
      {"", 0, "found the end, expected a number, a name or '('"},
      {"1 +", 3, "found the end, expected a number"},
      {"1 + * 2", 4, "found '*', expected a number"},
      {"1 2", 2, "found '2', expected an operator: + - * / %"},
      {"1 ^ 2", 2, "found '^', expected an operator"},
      {"(1 + 2", 0, "'(' is not closed"},
      {"2 * (1 2)", 7, "found '2', expected an operator or ')'"},
      {"1)", 1, "found ')', expected an operator"},
      {"1 / 0", 2, "division by zero"},
      {"5 % (1 - 1)", 2, "division by zero"},
      {"1e308 * 10", 6, "too large"},
      {"1e999", 0, "too large or too small"},
      {".", 0, "found '.', expected a number"},
      {"1.2.3", 3, "found '.', expected an operator"},
      {"fram", 0, "'fram' is not defined (define it by -D fram=value)"},
      {"1 + text", 4, "'text' is 'abc', expected a number"},
      {"empty", 0, "'empty' is '', expected a number"},
      {"odd", 0, "expected a number"},
      {"$frame", 0, "names are written without $ here"},
      {"tan(1)", 0, "unknown function 'tan', expected sin or cos"},
      {"frame(1)", 0, "unknown function 'frame'"},
      {"sin", 0, "'sin' is not defined"},
      {"\"a\"", 0, "found '\"', expected a number"},
      {"inf", 0, "'inf' is not defined"},
  };
  for (const Case& c : cases) {
    CAPTURE(std::string(c.text));
    const auto error = error_in(c.text);
    CHECK(error.first == c.at);
    CHECK_MESSAGE(contains(error.second, c.message), error.second);
  }
}

TEST_CASE("expressions: hostile lengths and depths are errors") {
  CHECK(contains(error_in(std::string(1'000'000, '1')).second, "longer than 1000 characters"));
  CHECK(contains(error_in(std::string(400, '(') + "1" + std::string(400, ')')).second, "nested deeper than 50 levels"));
  CHECK(contains(error_in(std::string(900, '-') + "1").second, "nested deeper than 50 levels"));
  CHECK(contains(error_in(repeated("sin(", 150) + "1" + repeated(")", 150)).second, "nested deeper than 50 levels"));
  CHECK(evaluate(std::string(40, '(') + "1" + std::string(40, ')')) == 1);
  CHECK(evaluate("1" + repeated("+1", 499)) == 500);  // length does not nest
}

TEST_CASE("expressions: results are the shortest text that parses to the same value") {
  CHECK(expression_result(6) == "6");
  CHECK(expression_result(-0.0) == "0");
  CHECK(expression_result(-36) == "-36");
  CHECK(expression_result(1e15) == "1000000000000000");
  CHECK(expression_result(100000) == "100000");
  CHECK(expression_result(0.1) == "0.1");
  for (const double value : {1.0 / 3, 1e-300, 1.7976931348623157e308, 123456.789, std::sin(1.0), -2.5e17})
    CHECK(std::stod(expression_result(value)) == value);
}

TEST_CASE("definitions: names and expressions are substituted") {
  Definitions definitions({{"a", "1"}, {"ab", "2"}, {"n", "4"}});
  const auto fail = [](const SceneError& error) { throw SceneError(error); };
  const TextLocation position{{"f", 3}, 10};
  CHECK(definitions.substitute("x$a.$abc $ $", position, fail) == "x1.2c $ $");
  CHECK(definitions.substitute("f_$(n * (a + 1)).png$a", position, fail) == "f_8.png1");
  CHECK(definitions.substitute_defined("$x $a $$a", position, fail) == "$x 1 $1");
  CHECK_THROWS_WITH(definitions.substitute("$x", position, fail),
                    "f:3: parameter '$x' is not defined (define it by -D x=value or <default>)");
  CHECK_THROWS_WITH(definitions.substitute_defined("a $(1 + x)", position, fail),
                    "f:3: column 18: '$(1 + x)': 'x' is not defined (define it by -D x=value)");
  CHECK_THROWS_WITH(definitions.substitute("$(1 + (2)", position, fail),
                    "f:3: column 10: '$(1 + (2)': '$(' is not closed, expected ')'");
  // Errors that do not throw leave the text empty.
  int errors = 0;
  CHECK(definitions.substitute("<$x|$(2*)|$(2*3)>", position, [&](const SceneError&) { ++errors; }) == "<||6>");
  CHECK(errors == 2);
  // Unclosed parentheses take linear time.
  CHECK(definitions.substitute(repeated("$(", 200'000), position, [](const SceneError&) {}).empty());
}

TEST_CASE("definitions: unused names of -D are errors") {
  Definitions definitions({{"frame", "1"}, {"size", "2"}});
  const auto fail = [](const SceneError& error) { throw SceneError(error); };
  definitions.substitute("$(frame + 1)", {}, fail);
  CHECK_THROWS_WITH(definitions.reject_unused("f"), "f: the scene has no parameter 'size' for -D to set");
  definitions.add_default("size", "3");
  CHECK_NOTHROW(definitions.reject_unused("f"));
  CHECK(definitions.substitute("$size", {}, fail) == "2");
}

TEST_CASE("definitions: the number of a frame may have a number of digits") {
  const auto fail = [](const SceneError& error) { throw SceneError(error); };
  const auto replaced = [&](const std::string& text, const std::string& frame) {
    return Definitions({{"frame", frame}, {"other", "7"}}).substitute(text, {}, fail);
  };
  CHECK(replaced("a_$frame4.vdb", "12") == "a_0012.vdb");
  CHECK(replaced("$frame1_$frame2_$frame9", "12") == "12_12_000000012");
  CHECK(replaced("$frame4", "123456") == "123456");
  CHECK(replaced("$frame0 $frame $other4", "12") == "120 12 74");
  for (const char* const value : {"-3", "1.5", "", "a"}) CHECK(replaced("$frame4", value) == std::string(value) + "4");
  CHECK(Definitions({{"frame", "1"}, {"frame4", "x"}}).substitute("$frame4", {}, fail) == "x");
}

TEST_CASE("expressions in XML: attributes of all elements") {
  const auto radius = [](const std::string& inside, const ReadOptions& options = {}) {
    return radius_of(read_text(mitsuba_scene(inside), options));
  };
  const std::string sphere =
      "<default name='frame' value='3'/><default name='next' value='$(frame + 1)'/>\n"
      "<shape type='sphere'><float name='radius' value='$(next * 0.5)'/></shape>";
  CHECK(radius(sphere) == 2);
  CHECK(radius(sphere, with("frame", "9")) == 5);
  const Description film =
      read_text(mitsuba_scene("",
                              "<sensor type='perspective'><film type='hdrfilm'><integer name='width' value='$(2*300)'/>"
                              "<integer name='height' value='$(100/2)'/></film></sensor>"));
  CHECK(film.film.width == 600);
  CHECK(film.film.height == 50);
  // Lines and columns
  CHECK(error_of_text(mitsuba_scene("<shape type='sphere'>\n  <float name='radius' value='1$(2 +)'/></shape>")) ==
        "scene.xml:5: column 37: '$(2 +)': found the end, expected a number, a name or '('");
  CHECK(error_of_text(mitsuba_scene("<shape type='sphere'>\n  <float name='radius'\n  value='$(frame)'/></shape>")) ==
        "scene.xml:6: column 12: '$(frame)': 'frame' is not defined (define it by -D frame=value)");
  CHECK(contains(
      error_of_text(mitsuba_scene("<shape type='sphere'>\n<vector name='center' value='1\n$(1/0) 2'/></shape>")),
      "scene.xml:5: '$(1/0)': division by zero"));
  ReadOptions lenient;
  lenient.lenient = true;
  const Description left_out =
      read_text(mitsuba_scene("<shape type='sphere'><string name='id' value='a$(x)'/></shape>"), lenient);
  CHECK(contains(left_out.substitutions.at(0), "'x' is not defined (define it by -D x=value) (left empty)"));
}

TEST_CASE("pbrt: -D replaces names and expressions are evaluated") {
  CHECK(pbrt_radius("$(1 + 2)") == 3);
  CHECK(pbrt_radius("[ $(6/4) ]") == 1.5f);
  CHECK(pbrt_radius("[$r]", with("r", "2.5")) == 2.5f);
  CHECK(pbrt_radius("$r0", with("r", "2")) == 20);
  CHECK(pbrt_radius("1$(r)e$(r - 1) # $( $r", with("r", "2")) == 120);
  CHECK(contains(pbrt_error(pbrt_sphere("$r")), "scene.pbrt:3: found '$r', expected a value of the float 'radius'"));
  CHECK(contains(pbrt_error(pbrt_sphere("$r")), "(define names after $ by -D name=value)"));
  CHECK(pbrt_error(pbrt_sphere("[ $(2 * r) ]")) ==
        "scene.pbrt:3: column 26: '$(2 * r)': 'r' is not defined (define it by -D r=value)");
  CHECK(pbrt_error(pbrt_sphere("$(2 *\n 3)")) ==
        "scene.pbrt:3: column 18: '$(' is not closed on its line, expected ')'");
  CHECK(contains(pbrt_error(pbrt_sphere("1"), with("r", "2")), "the scene has no parameter 'r' for -D to set"));
  CHECK(contains(pbrt_error(pbrt_sphere("$radiu"), with("radius", "2")), "found '$radiu'"));
}

TEST_CASE("pbrt: strings keep $ before names that are not defined") {
  const TemporaryFolder folder;
  const std::string mesh =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
  for (const char* name : {"$cost.ply", "a$.ply", "mesh_3.ply"}) write_below(folder, name, mesh);
  const auto file_of = [&](const std::string& name, const ReadOptions& options = {}) {
    const std::string text = "WorldBegin\nShape \"plymesh\" \"string filename\" \"" + name + "\"\n";
    const Description scene = read_scene(write_below(folder, "scene.pbrt", text), options);
    return std::get<MeshFileShape>(scene.shapes.at(0).geometry).file.filename().string();
  };
  CHECK(file_of("$cost.ply") == "$cost.ply");
  CHECK(file_of("a$.ply") == "a$.ply");
  CHECK(file_of("mesh_$frame.ply", with("frame", "3")) == "mesh_3.ply");
  CHECK(file_of("mesh_$(frame % 4).ply", with("frame", "7")) == "mesh_3.ply");
  write_below(folder, "included.pbrt", pbrt_sphere("$r").substr(11));
  write_below(folder, "scene.pbrt", "WorldBegin\nInclude \"included.pbrt\"\n");
  CHECK(radius_of(read_scene(folder / "scene.pbrt", with("r", "4"))) == 4);
}

}  // namespace sheaf::test_expression
