// Scenes of pbrt-v4: tokens, directives, cameras and samplers, and errors.
#include "scene/dialects/pbrt/reader.h"
#include "tests/support/capture.h"
#include "tests/support/files/deflate.h"
#include "tests/support/near.h"
#include "tests/support/pbrt_testing.h"

#include <doctest/doctest.h>

#include <array>
#include <string>
#include <utility>

namespace sheaf::test_pbrt {

using namespace test;
using namespace pbrt;

namespace {

std::string error_of_bytes(const std::string& text) {
  const TemporaryFolder folder;
  return error_of(write_below(folder, "scene.pbrt", text));
}

/// A scene with most kinds of directives.
const std::string kDiffuseScene = R"(Film "rgb" "integer xresolution" [ 16 ] # a comment "with a string"
Camera "perspective" "float fov" 40
Sampler "zsobol"
WorldBegin
Attribute "shape" "float radius" 2
AttributeBegin
  Translate 1 2 3
  Texture "t" "spectrum" "checkerboard" "rgb tex1" [ 1 0 0 ]
  Material "diffuse" "texture reflectance" "t"
  AreaLightSource "diffuse" "blackbody L" 5000
  Shape "sphere"
AttributeEnd
ObjectBegin "o"
  Shape "trianglemesh" "point3 P" [ 0 0 0 1 0 0 0 1 0 ]
ObjectEnd
ObjectInstance "o"
LightSource "point" "rgb I" [ 1 2 3 ]
)";

}  // namespace

TEST_CASE("pbrt: tokens are split as in pbrt") {
  Tokens tokens("Shape \"a b\\\"c\\\\\" # no \"token\" []\n[1 -2.5e1]true\"x\"", "f");
  using Kind = Token::Kind;
  const std::pair<Kind, std::string> expected[] = {
      {Kind::kWord, "Shape"},  {Kind::kString, "a b\"c\\"}, {Kind::kOpen, "["},    {Kind::kWord, "1"},
      {Kind::kWord, "-2.5e1"}, {Kind::kClose, "]"},         {Kind::kWord, "true"}, {Kind::kString, "x"}};
  int index = 0;
  for (const auto& [kind, text] : expected) {
    CAPTURE_BINDING(text);
    CHECK(tokens.current().kind == kind);
    CHECK(tokens.current().text == text);
    CHECK(tokens.where().line == (index++ < 2 ? 1 : 2));
    tokens.advance();
  }
  CHECK(tokens.current().kind == Kind::kEnd);
  tokens.advance();
  CHECK(tokens.current().kind == Kind::kEnd);
  CHECK_THROWS_AS(Tokens("\"no end\n\"", "f"), SceneError);
  CHECK_THROWS_AS(Tokens("\"\\q\"", "f"), SceneError);
  const auto number = [](const char* text) { return number_of(Tokens(text, "f").current(), {"f", 1}, "a number"); };
  CHECK(number("+3") == 3);
  CHECK(number("-.5E-1") == near(-0.05));
  CHECK(number("1e-400") == 0);
  for (const char* text : {"1e400", "nan", "inf", "1x", "\"1\"", "", "--1"}) CHECK_THROWS_AS(number(text), SceneError);
}

TEST_CASE("pbrt: values with and without brackets are equal") {
  const Description a = read_pbrt_world("Shape \"sphere\" \"float radius\" 2 \"float alpha\" 1");
  const Description b = read_pbrt_world("Shape \"sphere\" \"float radius\" [ 2 ] \"float alpha\" [1]");
  CHECK(dump(a) == dump(b));
  CHECK(std::get<SphereShape>(a.shapes[0].geometry).radius == 2);
}

TEST_CASE("pbrt: integers may be written as floats of integral value") {
  const Description d = read_pbrt_world("Shape \"sphere\"",
                                        "Integrator \"path\" \"float maxdepth\" 7\nSampler \"sobol\" "
                                        "\"integer pixelsamples\" 16.0");
  CHECK(d.integrator.max_depth == 8);
  CHECK(d.sampler.sample_count == 16);
  CHECK(contains(error_of_pbrt_world("Shape \"sphere\"", "Integrator \"path\" \"float maxdepth\" 7.5"),
                 "parameter 'maxdepth' of Integrator 'path' is 7.5, expected an integer"));
}

TEST_CASE("pbrt: the x axis of a camera points to the right") {
  const Description d = read_pbrt_world("", "LookAt 0 0 0  0 0 1  0 1 0 Camera \"perspective\" \"float fov\" 50");
  CHECK(d.camera.to_world.vector({1, 0, 0}).x == -1);
  CHECK(d.camera.to_world.vector({0, 0, 1}).z == 1);
  CHECK(d.camera.fov == 50);
  CHECK(d.camera.fov_axis == CameraDescription::FovAxis::kSmaller);
  CHECK(d.film.width == 1280);
  CHECK(d.film.filter.kind == PixelFilter::Kind::kGaussian);
  CHECK(d.sampler.sample_count == 16);
  CHECK(d.sampler.kind == SamplerKind::kZSobol);
  CHECK(d.integrator.max_depth == 6);
}

TEST_CASE("pbrt cameras: spherical cameras face the direction of pbrt with +y upwards") {
  const Description areas = read_pbrt_world("", "Camera \"spherical\"");
  CHECK(areas.camera.equal_area);
  CHECK(areas.camera.to_world.vector({0, 0, 1}).y == 1);
  CHECK(areas.camera.to_world.vector({1, 0, 0}).x == 1);
  const Description panorama = read_pbrt_world("", "Camera \"spherical\" \"string mapping\" \"equirectangular\"");
  CHECK(!panorama.camera.equal_area);
  CHECK(panorama.camera.to_world.vector({0, 0, 1}).x == -1);
  CHECK(panorama.camera.to_world.vector({0, 1, 0}).y == 1);
  CHECK(panorama.camera.to_world.vector({1, 0, 0}).z == 1);
  const Description lens =
      read_pbrt_world("",
                      "Film \"rgb\" \"integer xresolution\" 20 \"integer yresolution\" 10\n"
                      "Camera \"orthographic\" \"float lensradius\" 0.5 \"float focaldistance\" 7");
  CHECK(length(lens.camera.to_world.vector({lens.camera.aperture_radius, 0, 0})) == near(0.5));
  CHECK(lens.camera.focus_distance == 7);
}

TEST_CASE("pbrt: crop windows between pixels are rounded up at both ends") {
  const auto crop = [](const std::string& parameter) {
    const Description d = read_pbrt_world(
        "Shape \"sphere\"", "Film \"rgb\" \"integer xresolution\" 10 \"integer yresolution\" 7 " + parameter);
    REQUIRE(d.film.crop);
    return std::array{d.film.crop->x0, d.film.crop->x1, d.film.crop->y0, d.film.crop->y1};
  };
  CHECK(crop("\"float cropwindow\" [ 0.21 0.58 0.33 0.9 ]") == std::array{3, 6, 3, 7});
  CHECK(crop("\"float cropwindow\" [ 0.58 0.21 0.9 0.33 ]") == std::array{3, 6, 3, 7});
  CHECK(crop("\"float cropwindow\" [ -1 0.51 0 2 ]") == std::array{0, 6, 0, 7});
  CHECK(crop("\"integer pixelbounds\" [ 2 5 1 99 ]") == std::array{2, 5, 1, 7});
}

TEST_CASE("pbrt: samplers are read or replaced by similar ones") {
  const auto kind = [](const std::string& name) {
    return read_pbrt_world("", "Sampler \"" + name + "\"").sampler.kind;
  };
  CHECK(kind("independent") == SamplerKind::kIndependent);
  CHECK(kind("stratified") == SamplerKind::kStratified);
  CHECK(kind("zsobol") == SamplerKind::kZSobol);
  for (const char* name : {"halton", "paddedsobol", "pmj02bn", "sobol"}) CHECK(kind(name) == SamplerKind::kSobol);
}

TEST_CASE("pbrt: attributes and transforms and objects are saved and restored") {
  const Description d =
      read_pbrt_world(R"(
AttributeBegin Translate 1 0 0 Scale 2 2 2 ReverseOrientation Shape "sphere" AttributeEnd
Shape "sphere"
TransformBegin Rotate 90 0 0 1 Material "dielectric" TransformEnd
Shape "sphere"
ObjectBegin "o" Translate 0 5 0 Shape "sphere" ObjectEnd
Translate 7 0 0 ObjectInstance "o" Include "part.pbrt" ObjectInstance "o" Import "part.pbrt" ObjectInstance "o"
ObjectBegin "unused" Shape "sphere" ObjectEnd)",
                      "", [](const TemporaryFolder& folder) { write_below(folder, "part.pbrt", "Translate 1 0 0\n"); });
  REQUIRE(d.shapes.size() == 3);
  CHECK(d.shapes[0].to_world.point({1, 0, 0}).x == 3);
  CHECK(d.shapes[0].flip_normals);
  CHECK(!d.shapes[1].flip_normals);
  CHECK(d.shapes[1].to_world.point({1, 0, 0}).x == 1);
  CHECK(model_of<DiffuseDescription>(d, *d.shapes[1].material) != nullptr);
  CHECK(model_of<DielectricDescription>(d, *d.shapes[2].material) != nullptr);
  REQUIRE(d.groups.size() == 1);
  CHECK(d.groups[0].shapes[0].to_world.point({0, 0, 0}).y == 5);
  REQUIRE(d.instances.size() == 3);
  CHECK(d.instances[0].to_world[3] == 7);
  CHECK(d.instances[1].to_world[3] == 8);
  CHECK(d.instances[2].to_world[3] == 8);
  CHECK(d.files.size() == 2);
}

TEST_CASE("pbrt: errors have a line number") {
  const auto check = [](const std::string& world, const std::string& message) {
    CAPTURE(world);
    CHECK(error_of_pbrt_world(world) == message);
  };
  check("\nShap \"sphere\"", "scene.pbrt:4: found 'Shap', expected a directive, did you mean 'Shape'?");
  check("Shape \"spere\"",
        "scene.pbrt:3: unknown shape 'spere', did you mean 'sphere'? (known: bilinearmesh, curve, cylinder, disk, "
        "loopsubdiv, plymesh, sphere, trianglemesh)");
  check("Shape \"sphere\" \"float radios\" 2",
        "scene.pbrt:3: unknown parameter 'radios' of Shape 'sphere', did you mean 'radius'?");
  check("Shape \"sphere\"\n\"float radius\" [ 1 2 ]",
        "scene.pbrt:4: parameter 'radius' of Shape 'sphere' has 2 values, expected 1");
  check("Shape \"sphere\" \"float radius\" -1",
        "scene.pbrt:3: parameter 'radius' of Shape 'sphere' is -1, expected a positive number");
  check("Shape \"sphere\" \"flot radius\" 1",
        "scene.pbrt:3: unknown type 'flot' of a parameter, did you mean 'float'? (known: integer, float, point2, "
        "vector2, point3, vector3, normal3, point, vector, normal, rgb, blackbody, spectrum, bool, string, texture)");
  check("AttributeBegin", "scene.pbrt:3: AttributeBegin is not closed at the end of the file");
  check("AttributeEnd", "scene.pbrt:3: an end without AttributeBegin");
  check("ObjectInstance \"o\"", "scene.pbrt:3: the object 'o' is not defined");
  check("NamedMaterial \"m\"", "scene.pbrt:3: the material 'm' is not defined yet");
  CHECK(contains(error_of_pbrt_world("Scale 0 1 1"), "scene.pbrt:3: transform is not invertible"));
  check("Film \"rgb\"", "scene.pbrt:3: Film after WorldBegin, expected it before");
  CHECK(contains(error_of_pbrt_world("Include \"none.pbrt\""), "scene.pbrt:3: file 'none.pbrt' not found in "));
  CHECK(contains(error_of_pbrt_world("Include \"scene.pbrt\""), "includes itself"));
  CHECK(contains(
      error_of_pbrt_world("Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 3]"),
      "has 3, expected an index of 3 vertices"));
  CHECK(contains(error_of_pbrt_world("WorldEnd"), "pbrt-v3"));
  CHECK(contains(error_of_bytes("Film \"rgb\""), "the scene has no WorldBegin"));
  CHECK(contains(error_of_bytes(std::string("\x7f"
                                            "ELF\0\1\2\3",
                                            8)),
                 "expected a directive"));
  ReadOptions defines;
  defines.defines = {{"x", "1"}};
  const TemporaryFolder folder;
  CHECK_THROWS_AS(read_scene(write_below(folder, "scene.pbrt", "WorldBegin\n"), defines), Error);
}

TEST_CASE("pbrt: unsupported features are errors or replacements with a note") {
  for (const std::string world :
       {"Texture \"t\" \"spectrum\" \"marble\"", "Texture \"t\" \"float\" \"fbm\" \"integer octaves\" 3",
        "Texture \"t\" \"float\" \"checkerboard\" \"string mapping\" \"spherical\"",
        "MakeNamedMedium \"m\" \"string type\" \"homogeneous\" \"string preset\" \"x\""}) {
    CAPTURE(world);
    const std::string message = error_of_pbrt_world(world);
    CHECK(contains(message, "scene.pbrt:3: "));
    CHECK(contains(message, "not supported"));
    ReadOptions lenient;
    lenient.lenient = true;
    const TemporaryFolder folder;
    const Description d = read_scene(write_below(folder, "scene.pbrt", "\nWorldBegin\n" + world + "\n"), lenient);
    REQUIRE(d.substitutions.size() == 1);
    CHECK(contains(d.substitutions[0], "scene.pbrt:3: "));
  }
}

TEST_CASE("pbrt: every truncated scene is an error or a scene and never a crash") {
  const TemporaryFolder folder;
  CHECK(error_of(write_below(folder, "scene.pbrt", kDiffuseScene)) == "");
  int errors = 0;
  for (std::size_t size = 0; size < kDiffuseScene.size(); ++size)
    errors += error_of(write_below(folder, "scene.pbrt", kDiffuseScene.substr(0, size))).empty() ? 0 : 1;
  CHECK(errors > static_cast<int>(kDiffuseScene.size()) / 2);
  for (std::size_t i = 0; i < kDiffuseScene.size(); i += 3)  // one damaged character
    for (const char c : {'"', '[', '\0'}) {
      std::string damaged = kDiffuseScene;
      damaged[i] = c;
      error_of(write_below(folder, "scene.pbrt", damaged));
    }
}

TEST_CASE("pbrt: files may be compressed") {
  const TemporaryFolder folder;
  write_below(folder, "part.pbrt.gz", gzipped("Shape \"sphere\" \"float radius\" 3\n"));
  const std::string scene = gzipped("WorldBegin\nInclude \"part.pbrt.gz\"\n");
  CHECK(std::get<SphereShape>(read_scene(write_below(folder, "scene.pbrt.gz", scene)).shapes.at(0).geometry).radius ==
        3);
  for (std::size_t size = 0; size < scene.size(); ++size) {
    const std::string message = error_of(write_below(folder, "scene.pbrt.gz", scene.substr(0, size)));
    CHECK(contains(message, "scene.pbrt.gz: scene file is "));
  }
}

TEST_CASE("pbrt: the depth of nested attributes and includes is limited") {
  std::string deep;
  for (int i = 0; i < 20'000; ++i) deep += "AttributeBegin\n";
  CHECK(contains(error_of_pbrt_world(deep), "attributes are saved more than 10000 deep"));
  const TemporaryFolder folder;
  for (int i = 0; i < 40; ++i)
    write_below(folder, "part" + std::to_string(i) + ".pbrt", "Include \"part" + std::to_string(i + 1) + ".pbrt\"\n");
  CHECK(contains(error_of(write_below(folder, "scene.pbrt", "Include \"part0.pbrt\"\n")), "more than 32 deep"));
  // Each file includes the next one twice.
  for (int i = 0; i < 20; ++i)
    write_below(
        folder, "part" + std::to_string(i) + ".pbrt",
        "Include \"part" + std::to_string(i + 1) + ".pbrt\" Include \"part" + std::to_string(i + 1) + ".pbrt\"");
  write_below(folder, "part20.pbrt", "");
  CHECK(contains(error_of(write_below(folder, "scene.pbrt", "Include \"part0.pbrt\"\n")), "more than 10000 files"));
}

}  // namespace sheaf::test_pbrt
