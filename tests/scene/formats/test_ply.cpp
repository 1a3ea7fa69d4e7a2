// PLY files: encodings, number types, layouts, and malformed files.
#include "scene/formats/mesh_io.h"
#include "tests/scene/formats/ply_files.h"
#include "tests/support/files/mesh_files.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <random>
#include <string>
#include <vector>

namespace sheaf::test_ply {

using namespace test;
using namespace ply_files;

namespace {

/// Every number type, unknown elements and properties, lists between numbers, a quadrangle and a triangle.
std::string rich_file(Body::Encoding encoding) {
  using std::int16_t, std::int8_t, std::uint16_t, std::uint32_t, std::uint8_t;
  Body body(encoding);
  body.put<uint8_t>(2).put(1.5).put(2.5).put<int16_t>(-7);  // element 'junk'
  const double corners[5][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0.25}, {-3, 0.5, -2}};
  for (int i = 0; i < 5; ++i) {
    const double* c = corners[i];
    body.put(c[0]).put<uint8_t>(255).put(float(c[1])).put<uint16_t>(3).put<int8_t>(1).put<int8_t>(-2).put<int8_t>(3);
    body.put(float(c[2])).put(0.0f).put(0.0f).put(1.0f).put(float(i)).put(0.5f).put<uint32_t>(4000000000u);
  }
  body.put<int8_t>(9).put<int16_t>(4).put<uint16_t>(0).put<uint16_t>(1).put<uint16_t>(2).put<uint16_t>(3);
  body.put<uint8_t>(1).put(0.5f);
  body.put<int8_t>(9).put<int16_t>(3).put<uint16_t>(4).put<uint16_t>(1).put<uint16_t>(0);
  body.put<uint8_t>(0);
  return "ply\n" + body.format() +
         "comment element vertex 99\nobj_info property float x\n"
         "element junk 1\nproperty list uchar double values\nproperty short other\n"
         "element vertex 5\nproperty double x\nproperty uchar red\nproperty float32 y\n"
         "property list ushort int8 tags\nproperty float z\nproperty float nx\nproperty float ny\nproperty float nz\n"
         "property float s\nproperty float t\nproperty uint id\n"
         "element face 2\nproperty char flag\nproperty list int16 uint16 vertex_indices\n"
         "property list uint8 float weights\nend_header\n" +
         body.text();
}

}  // namespace

TEST_CASE("ply: all encodings give the same correct mesh") {
  const MeshFile ascii = read(rich_file(Body::Encoding::kAscii));
  REQUIRE(ascii.warnings.size() == 3);
  CHECK(contains(ascii.warnings[0], "element 'junk' not understood: left out"));
  CHECK(contains(ascii.warnings[1], "element 'vertex': properties 'red', 'tags', 'id' not understood: left out"));
  CHECK(contains(ascii.warnings[2], "element 'face': properties 'flag', 'weights' not understood: left out"));
  const Mesh& mesh = ascii.mesh;
  CHECK(mesh.positions == std::vector<Vec3f>{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0.25f}, {-3, 0.5f, -2}});
  CHECK(mesh.normals == std::vector<Vec3f>(5, {0, 0, 1}));
  REQUIRE(mesh.uvs.size() == 5);
  CHECK(mesh.uvs[3].x == 3.0f);
  CHECK(mesh.uvs[3].y == 0.5f);
  using Triangle = std::array<std::uint32_t, 3>;
  CHECK(mesh.triangles == std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}, {4, 1, 0}});
  for (const Body::Encoding encoding : kEncodings) CHECK(are_equal(read(rich_file(encoding)).mesh, mesh));
}

TEST_CASE("ply: every number type can be coordinate and index") {
  const auto check = [](const std::string& type, auto zero) {
    using T = decltype(zero);
    for (const Body::Encoding encoding : kEncodings) {
      Body body(encoding);
      for (const int c : {0, 0, 0, 100, 0, 0, 0, 100, 0}) body.put(static_cast<T>(c));
      body.put<std::uint8_t>(3).put(static_cast<T>(2)).put(static_cast<T>(0)).put(static_cast<T>(1));
      const std::string columns = "property " + type + " x\nproperty " + type + " y\nproperty " + type + " z\n";
      const Mesh mesh =
          read("ply\n" + body.format() + "element vertex 3\n" + columns + "element face 1\nproperty list uchar " +
               type + " vertex_index\nend_header\n" + body.text())
              .mesh;
      CHECK_MESSAGE((mesh.positions[1] == Vec3f{100, 0, 0}), type);
      CHECK(mesh.triangles[0] == std::array<std::uint32_t, 3>{2, 0, 1});
    }
  };
  check("char", std::int8_t{});
  check("uint8", std::uint8_t{});
  check("short", std::int16_t{});
  check("uint16", std::uint16_t{});
  check("int", std::int32_t{});
  check("uint32", std::uint32_t{});
  check("float", float{});
  check("float64", double{});
}

TEST_CASE("ply: faces may precede vertices") {
  const Mesh mesh = read(header("element face 1\nproperty list uchar int vertex_index\nelement vertex 3\n"
                                "property float x\nproperty float y\nproperty float z\n") +
                         "3 2 1 0\n0 0 0\n1 0 0\n0 1 0\n")
                        .mesh;
  CHECK(mesh.triangles[0] == std::array<std::uint32_t, 3>{2, 1, 0});
}

TEST_CASE("ply: incomplete normals are ignored and non-finite ones are missing") {
  const std::string position = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
  const std::string face = "element face 1\nproperty list uchar int vertex_indices\n";
  CHECK(read(header(position + "property float nx\nproperty float nz\n" + face) +
             "0 0 0 1 1\n1 0 0 1 1\n0 1 0 1 1\n3 0 1 2\n")
            .mesh.normals.empty());
  const Mesh mesh = read(header(position + "property float nx\nproperty float ny\nproperty float nz\n" + face) +
                         "0 0 0 0 0 1\n1 0 0 nan 0 0\n0 1 0 0 0 1\n3 0 1 2\n")
                        .mesh;
  CHECK(mesh.normals[1] == Vec3f{0, 0, 0});
}

TEST_CASE("ply: all line ends of the header are accepted") {
  const Mesh expected = read(header(kTriangle) + kTriangleBody).mesh;
  for (const std::string line_end : {"\r\n", "\r"}) {
    std::string text;
    for (const char c : header(kTriangle) + kTriangleBody) text += c == '\n' ? line_end : std::string(1, c);
    CHECK(are_equal(read(text).mesh, expected));
    Body body(Body::Encoding::kLittle);
    body.put(10.0f);  // the byte after a header that ends in CR may look like LF
    for (const int c : {0, 0, 1, 0, 0, 0, 1, 0}) body.put(static_cast<float>(c));
    body.put<std::uint8_t>(3).put(0).put(1).put(2);
    std::string binary;
    for (const char c : header(kTriangle, "binary_little_endian")) binary += c == '\n' ? line_end : std::string(1, c);
    CHECK(read(binary + body.text()).mesh.positions[0].x == 10.0f);
  }
}

TEST_CASE("ply: concave polygons keep their area and those of fewer than three corners are dropped") {
  const MeshFile file = read(header("element vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
                                    "element face 3\nproperty list uchar int vertex_indices\n") +
                             "-1 0 0\n0 9 0\n1 0 0\n0 10 0\n4 0 1 2 3\n2 0 1\n0\n");
  CHECK(file.mesh.triangles.size() == 2);
  CHECK(total_area(file.mesh) == near(1.0));
  REQUIRE(file.warnings.size() == 1);
  CHECK(contains(file.warnings[0], "2 faces"));
}

TEST_CASE("ply: triangle strips reverse every other triangle") {
  const Mesh mesh = read(header("element vertex 6\nproperty float x\nproperty float y\nproperty float z\n"
                                "element tristrips 1\nproperty list int int vertex_indices\n") +
                         "0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 2 0\n1 2 0\n10 0 1 2 3 4 -1 0 1 2 -1\n")
                        .mesh;
  REQUIRE(mesh.triangles.size() == 4);
  for (std::size_t i = 0; i < 4; ++i) CHECK(area_normal(mesh, i).z == 1.0f);
}

TEST_CASE("ply: infinite numbers are kept") {
  const Mesh mesh = read(header(kTriangle) + "nan inf -inf\n1e400 -1e400 1e-400\n+0.5 1e39 0\n3 0 1 2\n").mesh;
  CHECK(std::isnan(mesh.positions[0].x));
  CHECK(mesh.positions[0].z == -INFINITY);
  CHECK(mesh.positions[1].x == INFINITY);
  CHECK(mesh.positions[1].y == -INFINITY);
  CHECK(mesh.positions[1].z == 0.0f);
  CHECK(mesh.positions[2].x == 0.5f);
}

TEST_CASE("ply: malformed headers are errors") {
  const auto in_header = [](const std::string& elements) { return error_in(header(elements) + kTriangleBody); };
  CHECK(contains(error_of([] { read_ply("/nowhere/at/all.ply"); }), "not found"));
  CHECK(contains(error_in(""), "begins with 'ply'"));
  CHECK(contains(error_in("plyx\nformat ascii 1.0\n"), "begins with 'ply'"));
  CHECK(contains(error_in("obj\n"), "begins with 'ply'"));
  CHECK(contains(error_in("ply"), "without 'end_header'"));
  CHECK(contains(error_in("ply\nformat ascii 1.0\nelement vertex 3\n"), "without 'end_header'"));
  CHECK(contains(error_in("ply\nelement vertex 0\nend_header\n"), "no 'format' line"));
  CHECK(contains(error_in("ply\nformat ascii 2.0\nend_header\n"), "mesh.ply:2: expected version 1.0"));
  CHECK(contains(error_in("ply\nformat binary_litle_endian 1.0\nend_header\n"), "mean 'binary_little_endian'"));
  CHECK(contains(in_header("elemnt vertex 3\n"), ":3: expected a PLY header line, found 'elemnt', did you mean 'elem"));
  CHECK(contains(in_header("property float x\n"), "before the first element"));
  CHECK(contains(in_header("element vertex 3\nproperty flot x\n"), ":4: unknown PLY type 'flot', did you mean 'floa"));
  CHECK(contains(in_header("element vertex 3\nproperty list float int a\n"), "integer type for the length"));
  CHECK(contains(in_header("element vertex three\n"), "found 'three'"));
  CHECK(contains(in_header("element vertex -3\n"), "found '-3'"));
  CHECK(contains(in_header("element vertex 99999999999999999999999\n"), "found '999"));
  CHECK(contains(in_header(kTriangle + kTriangle), "appears twice"));
  CHECK(contains(in_header("element face 1\nproperty list uchar int vertex_indices\n"), "no element 'vertex'"));
  CHECK(contains(in_header("element vertex 1\nproperty float x\nproperty float y\n"), "without 'x', 'y' and 'z'"));
  CHECK(contains(in_header("element vertex 3\nproperty float x\nproperty float y\nproperty float z\n"), "no faces"));
  CHECK(contains(in_header("element vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
                           "element face 1\nproperty list uchar int corners\n"),
                 "no list 'vertex_indices'"));
}

TEST_CASE("ply: counts that the file cannot hold are errors and not allocations") {
  for (const std::string count : {"1000000000000000000", "18446744073709551615", "4000000000", "400"}) {
    for (const std::string format : {"ascii", "binary_little_endian", "binary_big_endian"}) {
      const std::string claims = "element vertex " + count +
                                 "\nproperty float x\nproperty float y\nproperty float z\n"
                                 "element face 1\nproperty list uchar int vertex_indices\n";
      CHECK(contains(error_in(header(claims, format) + std::string(1000, ' ')), "claims " + count + " rows"));
      const std::string faces =
          "element vertex 0\nproperty float x\nproperty float y\nproperty float z\n"
          "element face " +
          count + "\nproperty list int int vertex_indices\n";
      CHECK_FALSE(error_in(header(faces, format) + std::string(1000, ' ')).empty());
    }
  }
  CHECK(read(header("element nothing 1000000000000000000\n" + kTriangle) + kTriangleBody).mesh.triangles.size() == 1);
  const std::string list =
      "element vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 1\nproperty list int int vertex_indices\n";
  CHECK(contains(error_in(header(list) + "0 0 0\n2000000000 0 0 0\n"), "truncated"));
  CHECK(contains(error_in(header(list) + "0 0 0\n-1 0 0 0\n"), "impossible length"));
  CHECK(contains(error_in(header(list) + "0 0 0\n1.5 0 0 0\n"), "impossible length"));
  Body body(Body::Encoding::kBig);
  body.put(0.0f).put(0.0f).put(0.0f).put(2000000000).put(0);
  CHECK(contains(error_in(header(list, "binary_big_endian") + body.text()), "truncated"));
}

TEST_CASE("ply: malformed bodies are errors with their position") {
  CHECK(contains(error_in(header(kTriangle) + "0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n"),
                 "mesh.ply:13: row 0 of element 'face' (1 rows): expected the index of one of 3 vertices, found 3"));
  CHECK(contains(error_in(header(kTriangle) + "0 0 0\n1 0 0\n0 1 0\n3 0 -1 2\n"), "found -1"));
  CHECK(contains(error_in(header(kTriangle) + "0 0 0\n1 0 0\n0 1 0\n3 0 1 1.5\n"), "found 1.5"));
  CHECK(contains(error_in(header(kTriangle) + "0 0 0\n1 0 0\n0 1 0\n3 0 nan 1\n"), "found nan"));
  CHECK(contains(error_in(header(kTriangle) + "0 0 0\n1 x 0\n0 1 0\n3 0 1 2\n"),
                 "mesh.ply:11: row 1 of element 'vertex' (3 rows): expected a number, found 'x'"));
  CHECK(contains(error_in(header(kTriangle) + "0 0 0\n1 0,5 0\n0 1 0\n3 0 1 2\n"), "found '0,5'"));
  CHECK(contains(error_in(header(kTriangle) + "0 0 0\n1 0 0\n0 1 0\n3 0 1 "), "truncated"));
}

TEST_CASE("ply: truncated and randomly edited files give a mesh or an error") {
  std::mt19937 random(11);
  for (const Body::Encoding encoding : kEncodings) {
    const std::string valid = rich_file(encoding);
    for (std::size_t size = 0; size + 1 < valid.size(); size += size < 300 ? 7 : 1) {
      CHECK_FALSE(error_in(valid.substr(0, size)).empty());
    }
    for (int round = 0; round < 300; ++round) {
      std::string bytes = valid;
      for (int edit = 0; edit < 3; ++edit) bytes[random() % bytes.size()] = static_cast<char>(random());
      error_of([&] {
        const Mesh mesh = read(bytes).mesh;
        for (const auto& t : mesh.triangles) CHECK(std::max({t[0], t[1], t[2]}) < mesh.positions.size());
      });
    }
  }
}

}  // namespace sheaf::test_ply
