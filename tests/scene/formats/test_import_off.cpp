// OFF models, which Assimp imports.
#include "scene/formats/model_import.h"
#include "tests/support/files/model_files.h"
#include "tests/support/files/scene_files.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

#include <algorithm>

namespace sheaf::test_import_off {

using namespace test;

namespace {

bool has_importer() {
  if (!can_import_models()) MESSAGE("not tested: built without Assimp");
  return can_import_models();
}

/// The mesh of a model.
Mesh read(const std::string& text) {
  const TemporaryFolder folder;
  const Description d = read_scene(write_below(folder, "model.OFF", text));
  REQUIRE_FALSE(d.shapes.empty());
  return std::get<Mesh>(d.shapes[0].geometry);
}

std::string error_in(const std::string& text) {
  const TemporaryFolder folder;
  return error_of(write_below(folder, "model.off", text));
}

}  // namespace

TEST_CASE("off: polygons are imported, with edges that are sharp") {
  if (!has_importer()) return;
  const Mesh cube = read(cube_off());
  CHECK(cube.triangles.size() == 12);
  CHECK(cube.positions.size() == 24);
  CHECK(cube.normals.size() == 24);
  const auto [lowest, highest] = std::minmax_element(cube.positions.begin(), cube.positions.end(),
                                                     [](const Vec3f& a, const Vec3f& b) { return a.z < b.z; });
  CHECK(lowest->z == 2);
  CHECK(highest->z == 4);
}

TEST_CASE("off: colors of vertices are bytes in sRGB or linear fractions") {
  if (!has_importer()) return;
  const auto colors = [](const std::string& numbers) {
    const Mesh mesh =
        read("COFF\n3 1 3\n0 0 0 " + numbers + "\n1 0 0 " + numbers + "\n0 1 0 " + numbers + "\n3 0 1 2\n");
    REQUIRE_FALSE(mesh.attributes.empty());
    CHECK(mesh.attributes[0].name == "vertex_color");
    return mesh.attributes[0].values;
  };
  const std::vector<float> fractions = colors("0.5 0.25 0 1"), bytes = colors("255 128 0 255");
  CHECK(fractions[0] == near(0.5));
  CHECK(fractions[1] == near(0.25));
  CHECK(bytes[0] == near(1));
  CHECK(bytes[1] == near(0.2158605));
}

TEST_CASE("off: malformed files are errors with their name") {
  if (!has_importer()) return;
  for (const char* const text :
       {"", "OFF\n", "OFF\n3 1 3\n0 0 0\n1 0 0\n0 x 0\n3 0 1 2\n", "OFF\n3 0 0\n0 0 0\n1 0 0\n0 1 0\n"})
    CHECK(contains(error_in(text), "model.off"));
}

}  // namespace sheaf::test_import_off
