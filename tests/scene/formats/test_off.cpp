// OFF meshes.
#include "core/color/color.h"
#include "scene/formats/off.h"
#include "tests/support/files/model_files.h"
#include "tests/support/files/scene_files.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

namespace sheaf::test_off {

using namespace test;

namespace {

const std::string kSquare = "# a square\nOFF 4 1 4\n\n0 0 0\n1 0 0  # corner\n1 1 0\n0 1 0\n4 0 1 2 3\n";

MeshFile read_text_as_off(const std::string& text, BadFaces bad_faces = BadFaces::kError) {
  const TemporaryFolder folder;
  return read_off(write_below(folder, "model.off", text), bad_faces);
}
std::string message(const std::string& text) {
  const TemporaryFolder folder;
  return error_of(write_below(folder, "model.off", text));
}
const Mesh::Attribute& only_attribute(const Mesh& mesh) {
  REQUIRE(mesh.attributes.size() == 1);
  return mesh.attributes[0];
}

}  // namespace

TEST_CASE("off: headers, comments and counts have several forms") {
  const Mesh expected = read_text_as_off(kSquare).mesh;
  CHECK(expected.positions.size() == 4);
  CHECK(expected.positions[2].y == 1);
  CHECK(expected.triangles.size() == 2);
  for (const char* header : {"OFF\n4 1 4\n", "4 1 0\n", "OFF\r\n# none\r\n4 1\r\n"}) {
    const Mesh mesh = read_text_as_off(header + kSquare.substr(kSquare.find("0 0 0"))).mesh;
    CHECK(mesh.positions == expected.positions);
    CHECK(mesh.triangles == expected.triangles);
  }
}

TEST_CASE("off: faces have colours as fractions or as bytes") {
  const std::string tetrahedron = "OFF\n4 3 6\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n";
  const Mesh fractions = read_text_as_off(tetrahedron + "3 0 2 1 0.5 0.25 0\n3 0 1 3 1 0 0.75 0.5\n3 0 3 2\n").mesh;
  const Mesh::Attribute& colors = only_attribute(fractions);
  CHECK(colors.name == "face_color");
  CHECK(colors.values == std::vector<float>{0.5f, 0.25f, 0, 1, 0, 0.75f, 0.6f, 0.6f, 0.6f});
  const Mesh bytes = read_text_as_off(tetrahedron + "3 0 2 1 255 0 128\n3 0 1 3 1 0 0\n3 0 3 2 7\n").mesh;
  CHECK(only_attribute(bytes).values[0] == 1);
  CHECK(only_attribute(bytes).values[2] == near(srgb_to_linear(128 / 255.0f)));
  CHECK(only_attribute(bytes).values[3] == near(srgb_to_linear(1 / 255.0f)));
  CHECK(only_attribute(bytes).values[6] == 0.6f);
}

TEST_CASE("off: the triangles of a polygon have its colour") {
  const Mesh mesh = read_text_as_off(cube_off()).mesh;
  const Mesh::Attribute& colors = only_attribute(mesh);
  REQUIRE(colors.values.size() == 36);
  CHECK(colors.values[5 * 3] == kCubeColors[0][0]);
  CHECK(colors.values[6 * 3] == kCubeColors[1][0]);
}

TEST_CASE("off: vertices have colours, normals and texture coordinates") {
  const Mesh mesh = read_text_as_off(
                        "STCNOFF\n3 1 3\n0 0 0 0 0 1 0.5 0 0 1 0 0\n1 0 0 0 0 1 0 0.5 0 1 1 0\n"
                        "0 1 0 0 0 1 0 0 0.5 1 0 1\n3 0 1 2\n")
                        .mesh;
  REQUIRE(mesh.normals.size() == 3);
  CHECK(mesh.normals[1].z == 1);
  REQUIRE(mesh.uvs.size() == 3);
  CHECK(mesh.uvs[1].x == 1);
  CHECK(mesh.uvs[2].y == 1);
  CHECK(only_attribute(mesh).name == "vertex_color");
  CHECK(only_attribute(mesh).values == std::vector<float>{0.5f, 0, 0, 0, 0.5f, 0, 0, 0, 0.5f});
}

TEST_CASE("off: malformed files are errors with their line") {
  const auto changed = [](const char* from, const char* to) {
    std::string text = kSquare;
    return text.replace(text.find(from), std::string(from).size(), to);
  };
  CHECK(contains(message(changed("1 1 0", "1 x 0")), "model.off:6: 'x' is not a number"));
  CHECK(contains(message(changed("1 1 0", "1 1")), "model.off:6: the line has too few numbers"));
  CHECK(contains(message(changed("2 3", "2 4")), "model.off:8: a face refers to vertex 4, but there are 4"));
  CHECK(contains(message(changed("2 3", "2 -1")), "'-1' is not an index"));
  CHECK(contains(message(changed("4 0 1 2 3", "5 0 1 2 3")), "fewer than 5 vertices"));
  CHECK(contains(message(changed("4 0 1 2 3", "2 0 1")), "has no faces"));
  CHECK(contains(message(changed("4 0 1 2 3\n", "")), "ends before all faces"));
  CHECK(contains(message(changed("4 1 4", "4000000000 1 4")), "model.off:2: the file is too small"));
  CHECK(contains(message(changed("4 1 4", "4 4000000000 4")), "too small"));
  CHECK(contains(message(changed("OFF 4", "OFF BINARY 4")), "binary OFF file"));
  CHECK(contains(message(changed("OFF 4", "4OFF 4")), "other than three dimensions"));
  CHECK(contains(message(""), "ends before its counts"));
  CHECK(contains(message("OFF\n"), "ends before its counts"));
}

TEST_CASE("off: faces with missing vertices are dropped in lenient mode") {
  const MeshFile file =
      read_text_as_off("OFF\n3 2 3\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2 1 0 0\n3 0 1 9 0 1 0\n", BadFaces::kDrop);
  CHECK(file.mesh.triangles.size() == 1);
  CHECK(only_attribute(file.mesh).values == std::vector<float>{1, 0, 0});
  REQUIRE(file.warnings.size() == 1);
  CHECK(contains(file.warnings[0], "vertex 9"));
}

TEST_CASE("off: a model is rendered on a floor with its colours") {
  const TemporaryFolder folder;
  const Description d = read_scene(write_below(folder, "cube.OFF", cube_off()), {});
  REQUIRE(d.shapes.size() == 2);
  CHECK(std::get<Mesh>(d.shapes[0].geometry).normals.size() >= 24);
  REQUIRE(d.textures.size() >= 1);
  CHECK(std::get<MeshAttributeDescription>(d.textures[0].model).name == "face_color");
}

}  // namespace sheaf::test_off
