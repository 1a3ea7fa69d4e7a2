// STL meshes.
#include "scene/formats/stl.h"
#include "tests/support/files/scene_files.h"

#include <doctest/doctest.h>

#include <cstring>

namespace sheaf::test_stl {

using namespace test;

namespace {

const char* const kSquare =
    "solid square\nfacet normal 0 0 1\n outer loop\n  vertex 0 0 0\n  vertex 1 0 0\n  vertex 1 1 0\n "
    "endloop\nendfacet\n"
    "facet normal 0 0 1\n outer loop\n  vertex 0 0 0\n  vertex 1 1 0\n  vertex -0 1e0 0\n endloop\nendfacet\n"
    "endsolid square\n";

std::string binary(const std::vector<float>& corners, std::uint32_t triangles) {
  std::string bytes(80, ' ');
  const auto append = [&](const void* data, std::size_t size) { bytes.append(static_cast<const char*>(data), size); };
  append(&triangles, 4);
  const float normal[3] = {0, 0, 1};
  for (std::size_t i = 0; i + 9 <= corners.size(); i += 9) {
    append(normal, 12);
    append(corners.data() + i, 36);
    bytes.append(2, '\0');
  }
  return bytes;
}

MeshFile read_bytes_as_stl(const std::string& bytes) {
  const TemporaryFolder folder;
  return read_stl(write_below(folder, "model.stl", bytes));
}

}  // namespace

TEST_CASE("stl: ASCII and binary files give the same mesh with shared vertices") {
  const Mesh text = read_bytes_as_stl(kSquare).mesh;
  const Mesh bytes = read_bytes_as_stl(binary({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 0, 0, 1, 1, 0, -0.0f, 1, 0}, 2)).mesh;
  CHECK(text.positions.size() == 4);
  CHECK(text.triangles == bytes.triangles);
  CHECK(text.positions[2].y == 1);
  CHECK(text.normals.empty());
}

TEST_CASE("stl: a binary file that begins with 'solid' is binary") {
  std::string bytes = binary({0, 0, 0, 1, 0, 0, 1, 1, 0}, 1);
  std::memcpy(bytes.data(), "solid", 5);
  CHECK(read_bytes_as_stl(bytes).mesh.triangles.size() == 1);
}

TEST_CASE("stl: malformed files are errors, with the line of a bad number") {
  const auto message = [](const std::string& bytes) {
    const TemporaryFolder folder;
    return error_of(write_below(folder, "model.stl", bytes));
  };
  std::string bad = kSquare;
  bad.replace(bad.find("1 1 0"), 1, "x");
  CHECK(contains(message(bad), "model.stl:6: 'x' is not a number"));
  CHECK(contains(message("solid a\nendsolid\n"), "has no triangles"));
  CHECK(contains(message("solid a\nvertex 1 2 3\n"), "ends inside a triangle"));
  CHECK(contains(message(binary({0, 0, 0, 1, 0, 0, 1, 1, 0}, 9)), "truncated"));
}

TEST_CASE("stl: a model has creased normals") {
  const TemporaryFolder folder;
  const Description d = read_scene(write_below(folder, "model.STL", kSquare), {});
  REQUIRE_FALSE(d.shapes.empty());
  CHECK(std::get<Mesh>(d.shapes[0].geometry).normals.size() >= 4);
}

}  // namespace sheaf::test_stl
