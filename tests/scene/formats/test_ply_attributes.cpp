// Attributes in PLY files: names, channels, encodings, and warnings.
#include "tests/scene/formats/ply_files.h"
#include "tests/support/files/mesh_files.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

#include <cstdint>
#include <limits>
#include <sstream>
#include <string>
#include <tuple>
#include <vector>

namespace sheaf::test_ply_attributes {

using namespace test;
using namespace ply_files;

namespace {

/// A triangle whose vertices and face have additional properties. All rows have equal `values`.
template <class... V, class... F>
MeshFile with_attributes(const std::string& vertex_columns, std::tuple<V...> vertex, const std::string& face_columns,
                         std::tuple<F...> face, Body::Encoding encoding = Body::Encoding::kAscii) {
  Body body(encoding);
  for (const int corner : {0, 1, 2}) {
    body.put(float(corner == 1)).put(float(corner == 2)).put(0.0f);
    std::apply([&](auto... value) { (body.put(value), ...); }, vertex);
  }
  body.put<std::uint8_t>(3).put(0).put(1).put(2);
  std::apply([&](auto... value) { (body.put(value), ...); }, face);
  return read("ply\n" + body.format() + "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n" +
              vertex_columns + "element face 1\nproperty list uchar int vertex_indices\n" + face_columns +
              "end_header\n" + body.text());
}

/// "property T a", "property T b" ... for the names in "a b ...".
std::string columns(const std::string& type, const std::string& names) {
  std::string text;
  std::istringstream words(names);
  for (std::string name; words >> name;) text += "property " + type + " " + name + "\n";
  return text;
}

}  // namespace

TEST_CASE("ply: attributes are named after their properties") {
  const auto names = [](const std::string& first, const std::string& second, const std::string& third) {
    const MeshFile file = with_attributes(columns("float", first + " " + second + " " + third),
                                          std::tuple(0.25f, 0.5f, 0.75f), "", std::tuple());
    std::string found;
    for (const Mesh::Attribute& a : file.mesh.attributes) {
      found += (found.empty() ? "" : " ") + a.name + ":" + std::to_string(a.channels);
      CHECK(a.values.size() == 3 * static_cast<std::size_t>(a.channels));
      CHECK(a.values[0] == a.values[static_cast<std::size_t>(a.channels)]);
    }
    return found;
  };
  CHECK(names("r", "g", "b") == "vertex_color:3");
  CHECK(names("red", "green", "blue") == "vertex_color:3");
  CHECK(names("b", "r", "g") == "vertex_color:3");
  CHECK(names("foo_r", "foo_g", "foo_b") == "vertex_foo_color:3");
  CHECK(names("foo_x", "foo_y", "foo_z") == "vertex_foo:3");
  CHECK(names("my_long_0", "my_long_1", "my_long_2") == "vertex_my_long:3");
  CHECK(names("a_1", "a_2", "a_3") == "vertex_a:3");
  CHECK(names("a_0", "b_x", "c_r") == "vertex_a:1 vertex_b:1 vertex_c_color:1");
  CHECK(names("a_x", "b_x", "a_y") == "vertex_a:1 vertex_b:1");
  CHECK(names("quality", "flags", "a_q") == "");
  CHECK(names("red", "green", "alpha") == "");
  CHECK(names("s", "t", "a_x") == "vertex_a:1");
  CHECK(names("_x", "x_", "a_xy") == "");
}

TEST_CASE("ply: attributes of vertices and faces are read in every encoding") {
  for (const Body::Encoding encoding : kEncodings) {
    const MeshFile file = with_attributes(
        columns("float", "b g") + columns("double", "r temperature_0") + "property list uchar int tags\n",
        std::tuple(0.75f, 0.5f, 0.25, 300.0, std::uint8_t{2}, 7, 8), columns("float", "q_x q_y q_z r g b"),
        std::tuple(1.0f, 2.0f, 3.0f, 0.125f, 0.25f, 0.5f), encoding);
    REQUIRE(file.warnings.size() == 1);
    CHECK(contains(file.warnings[0], "element 'vertex': property 'tags' not understood: left out"));
    REQUIRE(file.mesh.attributes.size() == 4);
    CHECK(file.mesh.attributes[0].values == std::vector<float>{.25f, .5f, .75f, .25f, .5f, .75f, .25f, .5f, .75f});
    CHECK(file.mesh.attributes[1].name == "vertex_temperature");
    CHECK(file.mesh.attributes[1].values == std::vector<float>{300, 300, 300});
    CHECK(file.mesh.attributes[2].name == "face_color");
    CHECK(file.mesh.attributes[2].values == std::vector<float>{0.125f, 0.25f, 0.5f});
    CHECK(file.mesh.attributes[3].name == "face_q");
    CHECK(file.mesh.attributes[3].values == std::vector<float>{1, 2, 3});
  }
}

TEST_CASE("ply: integer attributes are sRGB fractions of their maximum and non-finite ones are zero") {
  const auto first = [](const std::string& type, auto value) {
    const MeshFile file = with_attributes(columns(type, "r g b"), std::tuple(value, value, value), "", std::tuple());
    return double(file.mesh.attributes.at(0).values.at(0));
  };
  CHECK(first("uchar", std::uint8_t{255}) == 1.0);
  CHECK(first("uchar", std::uint8_t{128}) == near(0.21586, 1e-4));
  CHECK(first("ushort", std::uint16_t{32768}) == near(0.21404809, 1e-6));  // value of Mitsuba 3.9
  CHECK(first("int", 32768) == near(1.1810208e-06, 1e-6));                 // value of Mitsuba 3.9
  CHECK(first("char", std::int8_t{-100}) == near(-0.06094439, 1e-6));      // value of Mitsuba 3.9
  CHECK(first("float", 7.5f) == 7.5);
  CHECK(first("float", std::numeric_limits<float>::quiet_NaN()) == 0.0);
  CHECK(first("double", 1e300) == 0.0);
}

TEST_CASE("ply: unusable attributes are dropped with a warning") {
  const MeshFile two = with_attributes(columns("float", "a_x a_y"), std::tuple(1.0f, 2.0f), "", std::tuple());
  CHECK(two.mesh.attributes.empty());
  REQUIRE(two.warnings.size() == 1);
  CHECK(contains(two.warnings[0], "attribute 'vertex_a' has 2 channels, expected 1 or 3"));
  const MeshFile twice =
      with_attributes(columns("float", "a_x b_x a_0"), std::tuple(1.0f, 2.0f, 3.0f), "", std::tuple());
  REQUIRE(twice.mesh.attributes.size() == 2);
  CHECK(twice.mesh.attributes[0].values[0] == 1.0f);
  REQUIRE(twice.warnings.size() == 1);
  CHECK(contains(twice.warnings[0], "'vertex_a' appears twice"));
}

TEST_CASE("ply: attributes of polygons are copied to their triangles") {
  const std::string points = "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n";
  const std::string faces = "property list uchar int vertex_indices\nproperty float id_0\n";
  const std::string square = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";
  const MeshFile file =
      read(header(points + "element face 4\n" + faces) + square + "4 0 1 2 3 5\n2 0 1 6\n3 0 1 2 7\n3 1 2 3 8\n");
  REQUIRE(file.mesh.attributes.size() == 1);
  CHECK(file.mesh.attributes[0].values == std::vector<float>{5, 5, 7, 8});
  for (const bool strips_first : {true, false}) {
    const std::string strips = "element tristrips 1\nproperty list uchar int vertex_indices\n";
    const std::string face = "element face 1\n" + faces;
    const MeshFile mixed = read(header(points + (strips_first ? strips + face : face + strips)) + square +
                                (strips_first ? "4 0 1 2 3\n3 0 1 2 9\n" : "3 0 1 2 9\n4 0 1 2 3\n"));
    CHECK(mixed.mesh.attributes.at(0).values ==
          (strips_first ? std::vector<float>{0, 0, 9} : std::vector<float>{9, 0, 0}));
  }
}

TEST_CASE("ply: unknown properties are listed in one warning for each element") {
  CHECK(read(header(kTriangle) + kTriangleBody).warnings.empty());
  std::string elements = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n", row = "0 0 0";
  for (int i = 0; i < 100; ++i) {
    elements += "property float quality" + std::to_string(i) + std::string(200, 'q') + "\n";
    row += " 1";
  }
  elements += "element face 1\nproperty list uchar int vertex_indices\n";
  const MeshFile many = read(header(elements) + row + "\n" + row + "\n" + row + "\n3 0 1 2\n");
  REQUIRE(many.warnings.size() == 1);
  CHECK(contains(many.warnings[0], "'quality0qqq"));
  CHECK(contains(many.warnings[0], " and 88 more not understood"));
  CHECK(many.warnings[0].size() < 700);
}

}  // namespace sheaf::test_ply_attributes
