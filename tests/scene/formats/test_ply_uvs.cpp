// Texture coordinates in PLY files, of vertices and of the corners of faces, and the name of the texture.
#include "tests/scene/formats/ply_files.h"
#include "tests/support/files/mesh_files.h"

#include <doctest/doctest.h>

#include <cstdint>
#include <string>
#include <vector>

namespace sheaf::test_ply_uvs {

using namespace test;
using namespace ply_files;

namespace {

const std::string kCornerUvs = "property list uchar float texcoord\n";

/// A square of two triangles with the lists of texture coordinates `first` and `second` after their corners.
std::string square(const std::string& first, const std::string& second, const std::string& vertex_uvs = "") {
  const bool has_uvs = !vertex_uvs.empty();
  return header("element vertex 4\nproperty float x\nproperty float y\nproperty float z\n" +
                (has_uvs ? std::string("property float u\nproperty float v\n") : "") +
                "element face 2\nproperty list uchar int vertex_indices\n" + kCornerUvs) +
         "0 0 0" + vertex_uvs + "\n1 0 0" + vertex_uvs + "\n1 1 0" + vertex_uvs + "\n0 1 0" + vertex_uvs +
         "\n3 0 1 2 " + first + "\n3 0 2 3 " + second + "\n";
}

/// u and v of the corners of a triangle.
std::vector<float> corner_uvs(const Mesh& mesh, std::size_t triangle) {
  std::vector<float> uvs;
  for (const std::uint32_t vertex : mesh.triangles.at(triangle)) {
    uvs.push_back(mesh.uvs.at(vertex).x);
    uvs.push_back(mesh.uvs.at(vertex).y);
  }
  return uvs;
}

}  // namespace

TEST_CASE("ply: texture coordinates have several names and are flipped on request") {
  for (const std::string_view names : {"uv", "st"}) {
    for (const std::string prefix : {"", "texture_"}) {
      std::string columns;
      for (const char name : names) columns += "property float " + prefix + name + "\n";
      const std::string text = header("element vertex 3\nproperty float x\nproperty float y\nproperty float z\n" +
                                      columns + "element face 1\nproperty list uchar int vertex_indices\n") +
                               "0 0 0 .1 .2\n1 0 0 .3 .25\n0 1 0 nan .6\n3 0 1 2\n";
      const Mesh mesh = read(text).mesh;
      REQUIRE(mesh.uvs.size() == 3);
      CHECK(mesh.uvs[1].x == 0.3f);
      CHECK(mesh.uvs[1].y == 0.25f);
      CHECK(mesh.uvs[2].x == 0.0f);
      CHECK(read(text, true).mesh.uvs[1].y == 0.75f);
    }
  }
}

TEST_CASE("ply: vertices are shared where texture coordinates of corners agree and split elsewhere") {
  const MeshFile same = read(square("6 0 0 1 0 1 1", "6 0 0 1 1 0 1"));
  CHECK(same.mesh.positions.size() == 4);
  CHECK(corner_uvs(same.mesh, 0) == std::vector<float>{0, 0, 1, 0, 1, 1});
  CHECK(corner_uvs(same.mesh, 1) == std::vector<float>{0, 0, 1, 1, 0, 1});
  CHECK(same.warnings.empty());
  const MeshFile seam = read(square("6 0 0 .5 0 .5 1", "6 .5 0 1 1 .5 1"), true);
  CHECK(seam.mesh.positions.size() == 6);
  CHECK(corner_uvs(seam.mesh, 0) == std::vector<float>{0, 1, 0.5f, 1, 0.5f, 0});
  CHECK(corner_uvs(seam.mesh, 1) == std::vector<float>{0.5f, 1, 1, 0, 0.5f, 0});
  CHECK(seam.is_split);
  for (std::size_t t = 0; t < 2; ++t) CHECK(area_normal(seam.mesh, t) == Vec3f{0, 0, 1});
  CHECK(seam.mesh.positions[seam.mesh.triangles[1][1]] == Vec3f{1, 1, 0});
}

TEST_CASE("ply: texture coordinates of corners override those of vertices unless no face has any") {
  CHECK(corner_uvs(read(square("6 0 0 1 0 1 1", "0", " 7 7")).mesh, 1) == std::vector<float>(6, 0));
  CHECK(corner_uvs(read(square("6 0 0 1 0 1 1", "0", " 7 7")).mesh, 0) == std::vector<float>{0, 0, 1, 0, 1, 1});
  const MeshFile none = read(square("0", "0", " 7 7"));
  CHECK(corner_uvs(none.mesh, 0) == std::vector<float>(6, 7));
  CHECK_FALSE(none.is_split);
  CHECK(read(square("0", "0")).mesh.uvs.empty());
}

TEST_CASE(
    "ply: texture coordinates of corners are read in binary and before the indices and with attributes and strips") {
  for (const Body::Encoding encoding : kEncodings) {
    Body body(encoding);
    for (const float c : {0.f, 0.f, 0.f, 10.f, 1.f, 0.f, 0.f, 11.f, 1.f, 1.f, 0.f, 12.f, 0.f, 1.f, 0.f, 13.f})
      body.put(c);
    body.put<std::uint8_t>(4).put(1).put(0).put(3).put(2);  // a strip
    body.put<std::uint8_t>(8);
    for (const double uv : {0., 0., 1., 0., 1., 1., 0., 1.}) body.put(uv);
    body.put<std::uint8_t>(4).put(0).put(1).put(2).put(3);
    body.put<std::uint8_t>(4);
    for (const double uv : {9., 9., 9., 9.}) body.put(uv);
    body.put<std::uint8_t>(2).put(0).put(1);  // too short: dropped with its coordinates
    body.put<std::uint8_t>(6);
    for (const double uv : {0.25, 0., 1., 1., 0., 1.}) body.put(uv);
    body.put<std::uint8_t>(3).put(0).put(2).put(3);
    const MeshFile file = read(
        "ply\n" + body.format() +
        "element vertex 4\nproperty float x\nproperty float y\nproperty float z\nproperty float id_0\n"
        "element tristrips 1\nproperty list uchar int vertex_indices\n"
        "element face 3\nproperty list uchar double texcoord\nproperty list uchar int vertex_indices\nend_header\n" +
        body.text());
    const Mesh& mesh = file.mesh;
    REQUIRE(mesh.triangles.size() == 5);
    CHECK(corner_uvs(mesh, 0) == std::vector<float>(6, 0));
    CHECK(corner_uvs(mesh, 2) == std::vector<float>{0, 0, 1, 0, 1, 1});
    CHECK(corner_uvs(mesh, 3) == std::vector<float>{0, 0, 1, 1, 0, 1});
    CHECK(corner_uvs(mesh, 4) == std::vector<float>{0.25f, 0, 1, 1, 0, 1});
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
      const Vec3f p = mesh.positions[i];
      const float id = p.y > 0 ? (p.x > 0 ? 12.0f : 13.0f) : (p.x > 0 ? 11.0f : 10.0f);
      CHECK(mesh.attributes.at(0).values.at(i) == id);
    }
  }
}

TEST_CASE("ply: lists of texture coordinates of the wrong length are errors and NaN counts as 0") {
  CHECK(contains(
      error_in(square("6 0 0 1 0 1 1", "4 0 0 1 1")),
      "mesh.ply:16: row 1 of element 'face' (2 rows): list 'texcoord' has 4 numbers, expected two for each of 3 "
      "corners"));
  CHECK(contains(error_in(square("5 0 0 1 0 1", "0")), "has 5 numbers, expected two for each corner"));
  CHECK(contains(error_in(square("6 0 0 1 0 1 1", "200 0 0")), "truncated"));
  CHECK(corner_uvs(read(square("6 0 0 nan 0 1 inf", "0")).mesh, 0) == std::vector<float>{0, 0, 0, 0, 0, 0});
}

TEST_CASE("ply: the comment TextureFile names a texture and may contain spaces") {
  const auto texture = [](const std::string& comment) {
    return read(header(comment + kTriangle) + kTriangleBody).texture;
  };
  CHECK(texture("comment TextureFile my image.png\ncomment TextureFile other.png\n") == "my image.png");
  CHECK(texture("comment TextureFile\n").empty());
  CHECK(texture("comment texture a.png\n").empty());
}

}  // namespace sheaf::test_ply_uvs
