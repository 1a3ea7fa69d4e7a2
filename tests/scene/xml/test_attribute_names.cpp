// Textures that name mesh attributes which no mesh has.
#include "scene/compile/compile.h"
#include "tests/support/files/scene_files.h"

#include <doctest/doctest.h>

namespace sheaf::test_attribute_names {

using namespace test;

namespace {

/// A triangle with vertex colors.
const std::string kColored =
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
    "property float r\nproperty float g\nproperty float b\nelement face 1\nproperty list uchar int vertex_indices\n"
    "end_header\n0 0 0 1 0 0\n1 0 0 1 0 0\n0 1 0 1 0 0\n3 0 1 2\n";
const std::string kPlain = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

std::string attribute(const std::string& name, const std::string& property = "reflectance",
                      const std::string& id = "") {
  return "<texture type='mesh_attribute' name='" + property + "'" + id + "><string name='name' value='" + name +
         "'/></texture>";
}
std::string diffuse(const std::string& inside) { return "<bsdf type='diffuse'>" + inside + "</bsdf>"; }
std::string mesh(const std::string& format, const std::string& inside) {
  return "<shape type='" + format + "'><string name='filename' value='mesh." + format + "'/>" + inside + "</shape>";
}

/// The error and the warnings of compiling a scene.
struct Outcome {
  std::string error;
  std::vector<std::string> warnings;
};

Outcome compile(const std::string& inside, bool lenient = false) {
  const TemporaryFolder folder;
  write_below(folder, "mesh.ply", kColored);
  write_below(folder, "mesh.obj", kPlain);
  Outcome outcome;
  ReadOptions options;
  options.lenient = lenient;
  Description d =
      read_scene(write_below(folder, "scene.xml", mitsuba_scene(inside + "<emitter type='constant'/>")), options);
  try {
    ErrorSink errors(lenient, d.substitutions);
    CompileOptions compiling;
    compiling.errors = &errors;
    outcome.warnings = compile_scene(d, compiling)->warnings();
  } catch (const SceneError& error) { outcome.error = error.what(); }
  if (lenient) outcome.warnings = d.substitutions;
  return outcome;
}

}  // namespace

TEST_CASE("attribute names: a name that no mesh with the material has is an error with line and nearest name") {
  const Outcome outcome =
      compile(mesh("ply", "\n" + diffuse(attribute("vertex_colour", "reflectance", " id='paint'"))));
  CHECK(contains(outcome.error,
                 "scene.xml:5: texture 'paint': no mesh with this material has the attribute "
                 "'vertex_colour' (the scene's meshes have vertex_color), did you mean 'vertex_color'?"));
  CHECK(compile(mesh("ply", diffuse(attribute("vertex_color")))).error.empty());
}

TEST_CASE("attribute names: attributes of other meshes do not count and shapes that are not meshes have none") {
  const std::string paint = diffuse(attribute("vertex_color"));
  const std::string good = mesh("ply", paint);
  for (const std::string& bad : {mesh("obj", paint), "<shape type='sphere'>" + paint + "</shape>"}) {
    const Outcome outcome = compile(good + bad);
    CHECK(contains(outcome.error, "no mesh with this material has the attribute 'vertex_color'"));
  }
  CHECK(contains(compile(mesh("obj", paint)).error, "(no mesh of the scene has any)"));
}

TEST_CASE("attribute names: attributes are checked in every slot and in nested materials and textures") {
  const std::string wrong = attribute("face_x");
  const std::string board =
      "<texture type='checkerboard' name='reflectance'>" + attribute("face_x", "color1") + "</texture>";
  const std::string bsdfs[] = {
      diffuse(board),
      "<bsdf type='roughconductor'>" + attribute("face_x", "alpha") + "</bsdf>",
      "<bsdf type='mask'>" + attribute("face_x", "opacity") + diffuse("") + "</bsdf>",
      "<bsdf type='blendbsdf'>" + attribute("face_x", "weight") + diffuse("") + diffuse("") + "</bsdf>",
      "<bsdf type='blendbsdf'>" + diffuse("") + diffuse(wrong) + "</bsdf>",
      "<bsdf type='twosided'>" + diffuse("") + diffuse(wrong) + "</bsdf>",
      "<bsdf type='normalmap'>" + attribute("face_x", "normalmap") + diffuse("") + "</bsdf>",
      "<bsdf type='twosided'><bsdf type='bumpmap'>" + attribute("face_x", "x") + diffuse("") + "</bsdf></bsdf>",
  };
  for (const std::string& bsdf : bsdfs) {
    CAPTURE(bsdf);
    CHECK(contains(compile(mesh("ply", bsdf)).error, "has the attribute 'face_x'"));
  }
  const std::string light = "<emitter type='area'>" + attribute("face_x", "radiance") + "</emitter>";
  CHECK(contains(compile(mesh("ply", light)).error, "the shape that emits"));
  CHECK(contains(compile("<shape type='shapegroup' id='g'>" + mesh("ply", diffuse(wrong)) +
                         "</shape><shape type='instance'><ref id='g'/></shape>")
                     .error,
                 "has the attribute 'face_x'"));
}

TEST_CASE("attribute names: an attribute that only some meshes of a material have is a warning") {
  const std::string shared = "<bsdf type='diffuse' id='m'>" + attribute("vertex_color") + "</bsdf>";
  const Outcome outcome = compile(shared + mesh("ply", "<ref id='m'/>") + mesh("obj", "<ref id='m'/>"));
  CHECK(outcome.error.empty());
  REQUIRE(outcome.warnings.size() == 1);
  CHECK(contains(outcome.warnings[0], "1 of 2 shapes with this material lack the attribute 'vertex_color'"));
}

TEST_CASE("attribute names: unused materials are not checked and wireframes need no attributes") {
  CHECK(compile("<bsdf type='diffuse' id='m'>" + attribute("vertex_x") + "</bsdf>" + mesh("ply", "")).error.empty());
  CHECK(compile(mesh("obj", diffuse("<texture type='wireframe' name='reflectance'/>"))).error.empty());
}

TEST_CASE("attribute names: in lenient mode the texture becomes gray") {
  const Outcome outcome = compile(mesh("ply", diffuse(attribute("vertex_x"))), true);
  CHECK(outcome.error.empty());
  REQUIRE(outcome.warnings.size() == 1);
  CHECK(contains(outcome.warnings[0], "(the texture is gray)"));
}

}  // namespace sheaf::test_attribute_names
