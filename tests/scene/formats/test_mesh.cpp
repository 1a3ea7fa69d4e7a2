// Mesh operations: orientation under every kind of transform, normals, degenerate triangles.
#include "scene/formats/mesh.h"
#include "tests/support/files/mesh_files.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

#include <limits>

namespace sheaf::test_mesh {

using namespace test;

namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

Mesh triangle(Vec3f a, Vec3f b, Vec3f c) { return {{a, b, c}, {}, {}, {{0, 1, 2}}}; }

void check_near(Vec3f found, Vec3f expected, double epsilon = 1e-5) {
  CHECK(found.x == near(expected.x, epsilon));
  CHECK(found.y == near(expected.y, epsilon));
  CHECK(found.z == near(expected.z, epsilon));
}

/// Two triangles that meet at an angle: 0 1 2 in the plane z = 0, and 0 2 3 tilted.
Mesh folded_square() { return {{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0.5f}}, {}, {}, {{0, 1, 2}, {0, 2, 3}}}; }

/// A sphere of 2 x 24 x 12 triangles around the origin with exact normals.
Mesh sphere() {
  constexpr int kAround = 24, kUp = 12;
  Mesh mesh;
  for (int j = 0; j <= kUp; ++j) {
    for (int i = 0; i <= kAround; ++i) {
      const double theta = 3.14159265358979 * j / kUp, phi = 2 * 3.14159265358979 * i / kAround;
      mesh.positions.push_back(
          {float(std::sin(theta) * std::cos(phi)), float(std::sin(theta) * std::sin(phi)), float(std::cos(theta))});
    }
  }
  mesh.normals = mesh.positions;
  for (std::uint32_t j = 0; j < kUp; ++j) {
    for (std::uint32_t i = 0; i < kAround; ++i) {
      const std::uint32_t a = j * (kAround + 1) + i, b = a + kAround + 1;
      mesh.triangles.push_back({a, b, b + 1});
      mesh.triangles.push_back({a, b + 1, a + 1});
    }
  }
  return mesh;
}

}  // namespace

TEST_CASE("mesh: the rectangle has its corners and uvs and normal") {
  const Mesh mesh = rectangle_mesh();
  check_mesh(mesh, {});
  CHECK(mesh.triangles.size() == 2);
  CHECK(total_area(mesh) == near(4.0));
  for (std::size_t i = 0; i < 4; ++i) {
    const Vec3f p = mesh.positions[i];
    CHECK(mesh.normals[i] == Vec3f{0, 0, 1});
    CHECK(mesh.uvs[i].x == (p.x + 1) / 2);
    CHECK(mesh.uvs[i].y == (p.y + 1) / 2);
  }
  for (std::size_t i = 0; i < 2; ++i) CHECK(area_normal(mesh, i).z > 0);
}

TEST_CASE("mesh: the cube is closed and faces outwards and has the uvs of Mitsuba") {
  const Mesh mesh = cube_mesh();
  check_mesh(mesh, {});
  CHECK(mesh.positions.size() == 24);
  CHECK(mesh.triangles.size() == 12);
  CHECK(total_area(mesh) == near(24.0));
  Vec3f sum{0, 0, 0};
  for (std::size_t i = 0; i < 12; ++i) {
    const Vec3f n = area_normal(mesh, i);
    const Vec3f corner = mesh.positions[mesh.triangles[i][0]];
    CHECK(dot(n, corner) > 0);
    for (const std::uint32_t vertex : mesh.triangles[i]) CHECK(mesh.normals[vertex] == normalize(n));
    sum = sum + n;
  }
  CHECK(sum == Vec3f{0, 0, 0});
  const auto check_uv = [&](Vec3f position, Vec3f normal, Vec2f uv) {
    for (std::size_t i = 0; i < 24; ++i) {
      if (!(mesh.positions[i] == position && mesh.normals[i] == normal)) continue;
      CHECK(mesh.uvs[i].x == uv.x);
      CHECK(mesh.uvs[i].y == uv.y);
      return;
    }
    FAIL("no such vertex");
  };
  check_uv({1, -1, -1}, {0, -1, 0}, {0, 1});
  check_uv({-1, 1, -1}, {0, 1, 0}, {1, 1});
  check_uv({1, 1, 1}, {1, 0, 0}, {1, 0});
  check_uv({-1, -1, 1}, {0, 0, 1}, {0, 0});
  check_uv({-1, -1, 1}, {-1, 0, 0}, {0, 1});
  check_uv({1, -1, -1}, {0, 0, -1}, {1, 1});
}

TEST_CASE("mesh: normals stay perpendicular to the surface under any transform") {
  Matrix4 shear;
  shear.m = {{{2, 0.5, 0, 1}, {0, 0.1, -0.7, 2}, {0.3, 0, 5, 3}, {0, 0, 0, 1}}};
  Matrix4 mirrored = shear;
  for (double& m : mirrored.m[0]) m = -m;
  for (const Transform& transform :
       {Transform::scale({1, 20, 0.05f}), Transform(shear), Transform(mirrored),
        Transform::scale({1e-12f, 1e-12f, 1e-12f}), Transform::scale({1e15f, 1e15f, 1e15f})}) {
    Mesh mesh = rectangle_mesh();
    transform_mesh(mesh, transform);
    for (const auto& t : mesh.triangles) {
      const Vec3f a = mesh.positions[t[0]], n = mesh.normals[t[0]];
      CHECK(length(n) == near(1.0));
      CHECK(dot(n, normalize(mesh.positions[t[1]] - a) * 1.0f) == within(0, 1e-5));
      CHECK(dot(n, normalize(mesh.positions[t[2]] - a) * 1.0f) == within(0, 1e-5));
    }
    check_near(mesh.normals[0], normalize(transform.normal({0, 0, 1})));
  }
}

TEST_CASE("mesh: the front follows the vertex normals under mirroring and for wrong windings") {
  for (const Vec3f factors : {Vec3f{1, 1, 1}, Vec3f{-1, 1, 1}, Vec3f{1, 1, -3}, Vec3f{-2, -1, -1}, Vec3f{-1, 2, -1}}) {
    for (const bool wound_wrongly : {false, true}) {
      Mesh mesh = sphere();
      if (wound_wrongly) {
        for (auto& t : mesh.triangles) std::swap(t[0], t[1]);
      }
      transform_mesh(mesh, Transform::scale(factors));
      drop_degenerate_triangles(mesh);
      CHECK(mesh.triangles.size() == 2 * 24 * 11);
      for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        CHECK(dot(area_normal(mesh, i), mesh.positions[mesh.triangles[i][0]]) > 0);
      }
    }
  }
}

TEST_CASE("mesh: without vertex normals the front follows the winding and mirroring flips it") {
  Mesh mesh = triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  transform_mesh(mesh, Transform::scale({-1, 1, 1}));
  CHECK(area_normal(mesh, 0).z == -1.0f);
  CHECK(mesh.normals.empty());
  mesh = triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  transform_mesh(mesh, Transform::scale({1, 1, -1}));
  CHECK(area_normal(mesh, 0).z == 1.0f);
}

TEST_CASE("mesh: flipping reverses triangles and normals and flipping twice changes nothing") {
  Mesh mesh = cube_mesh();
  flip_mesh(mesh);
  for (std::size_t i = 0; i < 12; ++i) CHECK(dot(area_normal(mesh, i), mesh.positions[mesh.triangles[i][0]]) < 0);
  for (std::size_t i = 0; i < 24; ++i) CHECK(dot(mesh.normals[i], mesh.positions[i]) < 0);
  flip_mesh(mesh);
  CHECK(are_equal(mesh, cube_mesh()));
}

TEST_CASE("mesh: smooth normals are weighted by angle") {
  Mesh mesh = folded_square();
  compute_vertex_normals(mesh);
  check_near(mesh.normals[0], {0.2270461f, -0.2270461f, 0.94704807f});  // values of Mitsuba 3.9
  check_near(mesh.normals[1], {0, 0, 1});
  check_near(mesh.normals[2], {0.2270461f, -0.2270461f, 0.94704807f});
  check_near(mesh.normals[3], {0.40824828f, -0.40824828f, 0.81649655f});
  Mesh round = sphere();
  const std::vector<Vec3f> exact = round.normals;
  compute_vertex_normals(round);
  for (std::size_t i = 25; i + 25 < exact.size(); ++i) {
    if (i % 25 != 0 && i % 25 != 24) CHECK(dot(exact[i], round.normals[i]) > 0.999f);
  }
}

TEST_CASE("mesh: smooth normals are unit vectors where the mean is undefined") {
  Mesh mesh = triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  mesh.triangles.push_back({0, 2, 1});
  mesh.positions.push_back({5, 5, 5});
  mesh.positions.push_back({kNan, 0, 0});
  mesh.triangles.push_back({0, 1, 4});
  compute_vertex_normals(mesh);
  REQUIRE(mesh.normals.size() == 5);
  for (const Vec3f n : mesh.normals) CHECK(length(n) == near(1.0));
  CHECK(std::abs(mesh.normals[0].z) == 1.0f);
}

TEST_CASE("mesh: missing normals are replaced by smooth ones") {
  Mesh mesh = folded_square();
  mesh.normals = {{0, 0, 0}, {0, 0, 3}, {kNan, 0, 0}, {0, kInfinity, 1}};
  transform_mesh(mesh, Transform());
  check_near(mesh.normals[0], {0.2270461f, -0.2270461f, 0.94704807f});
  CHECK(mesh.normals[1] == Vec3f{0, 0, 1});
  check_near(mesh.normals[3], {0.40824828f, -0.40824828f, 0.81649655f});
}

TEST_CASE("mesh: degenerate triangles are dropped") {
  Mesh mesh;
  mesh.positions = {{0, 0, 0},    {1, 0, 0},         {0, 1, 0},     {2, 0, 0},
                    {kNan, 0, 0}, {0, kInfinity, 0}, {0, 0, 1e13f}, {1, 1, 0}};
  mesh.uvs.resize(8);
  for (std::size_t i = 0; i < 8; ++i) mesh.uvs[i].x = float(i);
  mesh.triangles = {{0, 1, 2}, {0, 1, 1}, {0, 1, 3},           {0, 1, 4}, {5, 1, 0},
                    {0, 6, 1}, {0, 1, 8}, {0, 1, 4000000000u}, {7, 2, 1}};
  CHECK(drop_degenerate_triangles(mesh) == 7);
  REQUIRE(mesh.triangles.size() == 2);
  check_mesh(mesh, {});
  CHECK(mesh.positions.size() == 4);
  CHECK(mesh.uvs[mesh.triangles[1][0]].x == 7.0f);
  CHECK(mesh.positions[mesh.triangles[1][0]] == Vec3f{1, 1, 0});
  CHECK(drop_degenerate_triangles(mesh) == 0);
}

TEST_CASE("mesh: no size within single precision makes a triangle degenerate") {
  for (const float scale : {1e-17f, 1e-9f, 1e-3f, 1.0f, 1e5f, 1e9f, 1e12f}) {
    Mesh mesh = triangle({0, 0, 0}, {scale, 0, 0}, {0, scale, 0});
    CHECK_MESSAGE(drop_degenerate_triangles(mesh) == 0, scale);
  }
  for (const float scale : {1e-30f, 1e-19f, 1.1e12f, 1e30f, 3e38f}) {
    Mesh mesh = triangle({0, 0, 0}, {scale, 0, 0}, {0, scale, 0});
    CHECK_MESSAGE(drop_degenerate_triangles(mesh) == 1, scale);
    CHECK(mesh.positions.empty());
  }
  Mesh needle = triangle({1000, 0, 0}, {1000.0001f, 1, 0}, {1000.0001f, 2, 0});
  CHECK(drop_degenerate_triangles(needle) == 0);
  Mesh hair = triangle({0, 0, 0}, {1, 1e-8f, 0}, {2, 0, 0});
  CHECK(drop_degenerate_triangles(hair) == 1);
}

TEST_CASE("mesh: a mesh scaled by 1e30 passes every step") {
  Mesh mesh = cube_mesh();
  transform_mesh(mesh, Transform::scale({1e30f, 1e30f, 1e30f}));
  for (const Vec3f n : mesh.normals) CHECK(length(n) == near(1.0));
  CHECK(drop_degenerate_triangles(mesh) == 12);
  compute_vertex_normals(mesh);
  CHECK(mesh.normals.empty());
}

TEST_CASE("mesh: inconsistent meshes are rejected") {
  Mesh mesh = rectangle_mesh();
  mesh.triangles[1][2] = 4;
  CHECK(contains(error_of([&] { check_mesh(mesh, {"scene.xml", 7}); }), "scene.xml:7: a triangle refers to vertex 4"));
  mesh = rectangle_mesh();
  mesh.normals.pop_back();
  CHECK(contains(error_of([&] { check_mesh(mesh, {}); }), "3 normals for 4 vertices"));
  mesh = rectangle_mesh();
  mesh.uvs.push_back({0, 0});
  CHECK(contains(error_of([&] { check_mesh(mesh, {}); }), "5 texture coordinates"));
}

TEST_CASE("mesh: attributes stay with their vertices and triangles") {
  Mesh mesh = rectangle_mesh();
  mesh.triangles.insert(mesh.triangles.begin() + 1, {0, 1, 1});
  mesh.positions.insert(mesh.positions.begin(), {9, 9, 9});
  for (auto* values : {&mesh.normals}) values->insert(values->begin(), {0, 0, 1});
  mesh.uvs.insert(mesh.uvs.begin(), {0, 0});
  for (auto& t : mesh.triangles) {
    for (std::uint32_t& vertex : t) ++vertex;
  }
  Mesh::Attribute attribute{"vertex_place", 3, {}};
  for (const Vec3f p : mesh.positions) attribute.values.insert(attribute.values.end(), {p.x, p.y, p.z});
  mesh.attributes = {attribute, {"face_id", 1, {10, 11, 12}}};
  check_mesh(mesh, {});
  CHECK(drop_degenerate_triangles(mesh) == 1);
  flip_mesh(mesh);
  check_mesh(mesh, {});
  CHECK(mesh.attributes[1].values == std::vector<float>{10, 12});
  REQUIRE(mesh.positions.size() == 4);
  for (std::size_t i = 0; i < 4; ++i) {
    const std::vector<float>& v = mesh.attributes[0].values;
    CHECK(mesh.positions[i] == Vec3f{v[3 * i], v[3 * i + 1], v[3 * i + 2]});
  }
  mesh.attributes[1].values.pop_back();
  CHECK(contains(error_of([&] { check_mesh(mesh, {}); }), "'face_id' has 1 values, expected 1 for each of 2"));
  mesh.attributes[1].values.push_back(0);
  mesh.attributes[0].channels = 1;
  CHECK(contains(error_of([&] { check_mesh(mesh, {}); }), "'vertex_place' has 12 values, expected 1 for each of 4"));
}

TEST_CASE("mesh: open edges are counted regardless of split vertices") {
  CHECK(open_edges(cube_mesh()).size() == 0);  // each face has its own vertices
  CHECK(open_edges(rectangle_mesh()).size() == 4);
  Mesh lidless = cube_mesh();
  lidless.triangles.pop_back();
  CHECK(open_edges(lidless).size() == 3);
  Mesh flipped = cube_mesh();
  flip_mesh(flipped);
  CHECK(open_edges(flipped).size() == 0);
  flip_mesh(lidless);
  CHECK(open_edges(lidless).size() == 3);
  Mesh zeros = cube_mesh();
  for (Vec3f& p : zeros.positions) p.z = p.z < 0 ? p.x * -0.0f : p.z;
  CHECK(open_edges(zeros).size() == 0);
  CHECK(open_edges(Mesh{}).size() == 0);
}

TEST_CASE("mesh: a subset of triangles can be extracted") {
  const Mesh cube = cube_mesh();
  const Mesh part = extract_triangles(cube, {7, 2});
  check_mesh(part, {});
  REQUIRE(part.triangles.size() == 2);
  CHECK(part.positions.size() == 6);
  CHECK(part.uvs.size() == 6);
  CHECK(part.triangles[0] == std::array<std::uint32_t, 3>{0, 1, 2});
  CHECK(area_normal(part, 0) == area_normal(cube, 7));
  CHECK(area_normal(part, 1) == area_normal(cube, 2));
  CHECK(extract_triangles(cube, {}).positions.empty());
}

TEST_CASE("mesh: large meshes are processed by all threads as small ones are") {
  // Copies of a sphere, whose triangles are in many ranges
  constexpr std::size_t kCopies = 300;
  Mesh small = sphere();
  const std::size_t vertices = small.positions.size(), triangles = small.triangles.size();
  small.normals.assign(vertices, Vec3f{0, 0, 0});
  Mesh large;
  for (std::size_t copy = 0; copy < kCopies; ++copy) {
    large.positions.insert(large.positions.end(), small.positions.begin(), small.positions.end());
    large.normals.insert(large.normals.end(), small.normals.begin(), small.normals.end());
    for (const auto& t : small.triangles) {
      const auto first = static_cast<std::uint32_t>(copy * vertices);
      large.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
    }
  }
  CHECK(large.triangles.size() > 150'000);
  Mesh broken = large;
  broken.triangles[100'000][1] = 999'999;
  broken.triangles[140'000][1] = 1'999'999;
  CHECK(contains(error_of([&] { check_mesh(broken, {}); }), "a triangle refers to vertex 999999"));
  check_mesh(large, {});
  const Transform mirror = Transform::scale({-1, 2, 3});
  transform_mesh(small, mirror);
  transform_mesh(large, mirror);
  int different = 0;
  for (std::size_t i = 0; i < large.positions.size(); ++i)
    different +=
        large.positions[i] == small.positions[i % vertices] && large.normals[i] == small.normals[i % vertices] ? 0 : 1;
  for (std::size_t i = 0; i < large.triangles.size(); ++i)
    different += large.triangles[i][1] % vertices == small.triangles[i % triangles][1] ? 0 : 1;
  CHECK(different == 0);
  CHECK(drop_degenerate_triangles(large) == kCopies * drop_degenerate_triangles(small));
}

}  // namespace sheaf::test_mesh
