// Normals of models without normals: smoothing groups, creases, seams.
#include "scene/formats/smooth_normals.h"

#include "scene/formats/mesh.h"
#include "tests/support/files/mesh_files.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

#include <numbers>

namespace sheaf::test_smooth_normals {

using namespace test;

namespace {

/// A cube whose faces share vertices.
Mesh shared_cube() {
  Mesh mesh;
  for (int i = 0; i < 8; ++i)
    mesh.positions.push_back({i & 4 ? 1.0f : -1.0f, i & 2 ? 1.0f : -1.0f, i & 1 ? 1.0f : -1.0f});
  const std::array<std::array<std::uint32_t, 4>, 6> faces{
      {{0, 1, 3, 2}, {4, 6, 7, 5}, {0, 4, 5, 1}, {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 5, 7, 3}}};
  for (const auto& f : faces) {
    mesh.triangles.push_back({f[0], f[1], f[2]});
    mesh.triangles.push_back({f[0], f[2], f[3]});
  }
  return mesh;
}

/// `sides` rectangles around z between z = 0 and z = 1.
Mesh prism(int sides) {
  Mesh mesh;
  const auto n = static_cast<std::uint32_t>(sides);
  for (std::uint32_t i = 0; i < n; ++i) {
    const float angle = 2 * std::numbers::pi_v<float> * static_cast<float>(i) / static_cast<float>(n);
    for (const float z : {0.0f, 1.0f}) mesh.positions.push_back({std::cos(angle), std::sin(angle), z});
  }
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t a = 2 * i, b = 2 * ((i + 1) % n);
    mesh.triangles.push_back({a, b, b + 1});
    mesh.triangles.push_back({a, b + 1, a + 1});
  }
  return mesh;
}

/// The smallest cosine between the normals of a corner and of its triangle.
float smallest_cosine(const Mesh& mesh) {
  float smallest = 1;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (const std::uint32_t v : mesh.triangles[t])
      smallest = std::min(smallest, dot(mesh.normals[v], normalize(area_normal(mesh, t))));
  return smallest;
}

void check_lengths(const Mesh& mesh) {
  REQUIRE(mesh.normals.size() == mesh.positions.size());
  for (const Vec3f& n : mesh.normals) CHECK(length(n) == near(1));
}

}  // namespace

TEST_CASE("smooth normals: a cube has flat faces unless it is one smoothing group") {
  for (const bool off : {false, true}) {
    Mesh cube = shared_cube();
    const std::vector<std::uint32_t> groups(off ? 12 : 0, 0);
    compute_creased_normals(cube, groups);
    check_lengths(cube);
    CHECK(smallest_cosine(cube) == near(1));
    CHECK(cube.positions.size() >= 24);
    check_mesh(cube, {});
  }
  Mesh smooth = shared_cube();
  const std::vector<std::uint32_t> one_group(12, 1);
  compute_creased_normals(smooth, one_group);
  CHECK(smooth.positions.size() == 8);
  for (std::size_t i = 0; i < 8; ++i) CHECK(dot(smooth.normals[i], normalize(smooth.positions[i])) == near(1));
}

TEST_CASE("smooth normals: smoothing groups are smooth inside and creased at common edges") {
  // Four sides of a prism: the first three are one group, the last is another.
  Mesh mesh = prism(8);
  std::vector<std::uint32_t> groups(16, 1);
  for (std::size_t t = 12; t < 16; ++t) groups[t] = 2;
  compute_creased_normals(mesh, groups);
  check_lengths(mesh);
  CHECK(mesh.positions.size() == 16 + 4);  // two edges are split
  const float inside = std::cos(std::numbers::pi_v<float> / 8);
  CHECK(smallest_cosine(mesh) == near(inside, 1e-3));
}

TEST_CASE("smooth normals: edges without groups are smooth below the crease angle") {
  for (const int sides : {8, 12, 40}) {  // 45 degrees and less
    Mesh mesh = prism(sides);
    compute_creased_normals(mesh, {});
    CHECK(mesh.positions.size() == 2 * static_cast<std::size_t>(sides));
    for (std::size_t i = 0; i < mesh.positions.size(); ++i)
      CHECK(dot(mesh.normals[i], Vec3f{mesh.positions[i].x, mesh.positions[i].y, 0}) == near(1));
  }
  for (const int sides : {3, 4, 6}) {  // 60 degrees and more
    Mesh mesh = prism(sides);
    compute_creased_normals(mesh, {});
    CHECK(mesh.positions.size() == 4 * static_cast<std::size_t>(sides));
    CHECK(smallest_cosine(mesh) == near(1));
  }
}

TEST_CASE("smooth normals: coincident vertices count as one and keep their attributes") {
  Mesh mesh = prism(40);
  const Mesh whole = mesh;
  mesh.uvs.resize(mesh.positions.size());
  append_vertex_copies(mesh, {0, 1});  // a seam: the last rectangle has its own vertices
  mesh.uvs[80] = mesh.uvs[81] = {1, 1};
  for (std::size_t t = 78; t < 80; ++t)
    for (std::uint32_t& v : mesh.triangles[t])
      if (v < 2) v += 80;
  for (const bool welded : {false, true}) {
    Mesh seam = mesh;
    if (welded) {
      compute_welded_normals(seam);
    } else {
      compute_creased_normals(seam, {});
    }
    REQUIRE(seam.positions.size() == 82);
    CHECK(length(seam.normals[0] - seam.normals[80]) < 1e-6f);
    CHECK(seam.uvs[0].x == 0.0f);
    CHECK(seam.uvs[80].x == 1.0f);
  }
  Mesh split = mesh;
  compute_vertex_normals(split);
  CHECK(length(split.normals[0] - split.normals[80]) > 1e-3f);
}

TEST_CASE("smooth normals: attributes of split vertices are duplicated") {
  Mesh cube = shared_cube();
  Mesh::Attribute color{"vertex_color", 3, {}}, face{"face_id", 1, {}};
  for (int i = 0; i < 24; ++i) color.values.push_back(static_cast<float>(i));
  for (int i = 0; i < 12; ++i) face.values.push_back(static_cast<float>(i));
  cube.attributes = {color, face};
  const Mesh before = cube;
  compute_creased_normals(cube, {});
  check_mesh(cube, {});
  CHECK(cube.attributes[1].values == face.values);
  for (std::size_t t = 0; t < 12; ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t was = before.triangles[t][k], is = cube.triangles[t][k];
      CHECK(cube.positions[is] == before.positions[was]);
      CHECK(cube.attributes[0].values[3 * is] == static_cast<float>(3 * was));
    }
}

TEST_CASE("smooth normals: edges of three triangles and opposite triangles and large fans are handled") {
  Mesh fins;
  fins.positions = {{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {-1, 0.1f, 0}, {-1, -0.1f, 0}};
  fins.triangles = {{0, 1, 2}, {0, 1, 3}, {0, 1, 4}, {1, 0, 2}};
  compute_creased_normals(fins, {});
  check_lengths(fins);
  Mesh fan;
  constexpr std::uint32_t kMany = 20000;
  fan.positions.push_back({0, 0, 0});
  for (std::uint32_t i = 0; i < kMany; ++i)
    fan.positions.push_back({std::cos(static_cast<float>(i)), std::sin(static_cast<float>(i)), 0.1f});
  for (std::uint32_t i = 1; i < kMany; ++i) fan.triangles.push_back({0, i, i + 1});
  compute_creased_normals(fan, {});
  check_lengths(fan);
}

}  // namespace sheaf::test_smooth_normals
