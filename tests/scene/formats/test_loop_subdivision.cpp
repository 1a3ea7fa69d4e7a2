// Loop subdivision: limits against closed forms, and invalid meshes.
#include "scene/formats/loop_subdivision.h"

#include "core/io/error.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

namespace sheaf::test_loop_subdivision {

namespace {

Mesh icosahedron() {
  const float a = 1, b = (1 + std::sqrt(5.0f)) / 2;
  Mesh mesh;
  mesh.positions = {{-a, b, 0},  {a, b, 0},  {-a, -b, 0}, {a, -b, 0}, {0, -a, b},  {0, a, b},
                    {0, -a, -b}, {0, a, -b}, {b, 0, -a},  {b, 0, a},  {-b, 0, -a}, {-b, 0, a}};
  mesh.triangles = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                    {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                    {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  return mesh;
}

/// A regularly triangulated square of n x n cells over [0, n]^2 with the given heights.
template <class Height> Mesh lattice(std::uint32_t n, Height height) {
  Mesh mesh;
  for (std::uint32_t j = 0; j <= n; ++j)
    for (std::uint32_t i = 0; i <= n; ++i) {
      const auto x = static_cast<float>(i), y = static_cast<float>(j);
      mesh.positions.push_back({x, y, height(x, y)});
    }
  for (std::uint32_t j = 0; j < n; ++j)
    for (std::uint32_t i = 0; i < n; ++i) {
      const std::uint32_t v = j * (n + 1) + i;
      mesh.triangles.push_back({v, v + 1, v + n + 2});
      mesh.triangles.push_back({v, v + n + 2, v + n + 1});
    }
  return mesh;
}

float distance(Vec3f a, Vec3f b) { return length(a - b); }

}  // namespace

TEST_CASE("subdivision: the limit surface does not depend on the level") {
  for (const Mesh& control :
       {icosahedron(), lattice(3, [](float x, float y) { return 0.3f * x * y - 0.1f * y * y; })}) {
    const Mesh at[] = {subdivide(control, 0), subdivide(control, 1), subdivide(control, 3)};
    CHECK(at[2].triangles.size() == 64 * control.triangles.size());
    for (std::size_t v = 0; v < control.positions.size(); ++v) {
      for (const int finer : {1, 2}) {
        CHECK(distance(at[0].positions[v], at[finer].positions[v]) < 2e-6f);
        CHECK(distance(at[0].normals[v], at[finer].normals[v]) < 2e-5f);
      }
    }
  }
}

TEST_CASE("subdivision: the limit of an icosahedron keeps its symmetry") {
  const Mesh sphere = subdivide(icosahedron(), 3);
  // The valence is 5 and the mean of the neighbors is the axis times 1 / sqrt(5). With Warren's weights, this share
  // remains.
  const double weight = 1 / (5 + 3 / (8 * (3.0 / 40))), radius = std::hypot(1.0, (1 + std::sqrt(5.0)) / 2);
  const double expected = radius * (1 - 5 * weight + 5 * weight / std::sqrt(5.0));
  for (std::size_t v = 0; v < 12; ++v) {
    CHECK(double{length(sphere.positions[v])} == near(expected, 1e-6));
    CHECK(double{dot(sphere.normals[v], normalize(sphere.positions[v]))} == near(1, 1e-6));
  }
  double worst = 1;
  for (std::size_t v = 0; v < sphere.positions.size(); ++v)
    worst = std::min(worst, double{dot(sphere.normals[v], normalize(sphere.positions[v]))});
  CHECK(worst > 0.99);
}

TEST_CASE("subdivision: planes stay planes and regular meshes give box splines") {
  const auto plane = [](float x, float y) { return 0.25f * x - 0.5f * y; };
  const Mesh flat = subdivide(lattice(4, plane), 2);
  const Vec3f normal = normalize(Vec3f{-0.25f, 0.5f, 1});
  for (std::size_t v = 0; v < flat.positions.size(); ++v) {
    CHECK(flat.positions[v].z == within(plane(flat.positions[v].x, flat.positions[v].y), 1e-6));
    CHECK(distance(flat.normals[v], normal) < 1e-6f);
  }
  // Quartic box splines shift x^2 by a constant: six neighbors with weight 1/12 each, four of them at x +- 1.
  const Mesh bowl = subdivide(lattice(6, [](float x, float) { return x * x; }), 0);
  const std::size_t middle = 3 * 7 + 3;
  CHECK(bowl.positions[middle].z == near(9 + 4.0 / 12));
  CHECK(distance(bowl.normals[middle], normalize(Vec3f{-6, 0, 1})) < 1e-5f);
}

TEST_CASE("subdivision: the boundary is the cubic B-spline of its control points") {
  const Mesh control = lattice(5, [](float x, float y) { return y == 0 ? std::sin(1.3f * x) : 0.0f; });
  const Mesh fine = subdivide(control, 4);
  // Between 2 and 3 on the lower side, far from the corners.
  int found = 0;
  for (const Vec3f p : fine.positions) {
    if (std::fabs(p.y) > 1e-6f || p.x < 2 || p.x > 3) continue;
    const double t = double{p.x} - 2, s = 1 - t;
    const double weights[] = {s * s * s, 3 * t * t * t - 6 * t * t + 4, 3 * s * s * s - 6 * s * s + 4, t * t * t};
    double expected = 0;
    for (std::size_t k = 0; k < 4; ++k) expected += weights[k] / 6 * double{control.positions[1 + k].z};
    CHECK(double{p.z} == within(expected, 1e-6));
    ++found;
  }
  CHECK(found == 17);
}

TEST_CASE("subdivision: inconsistent meshes and excessive levels are errors") {
  const auto message = [](std::vector<std::array<std::uint32_t, 3>> triangles) -> std::string {
    Mesh mesh = icosahedron();
    mesh.triangles = std::move(triangles);
    try {
      subdivide(mesh, 1);
    } catch (const SceneError& error) { return error.what(); }
    return "";
  };
  CHECK(message({{0, 1, 2}, {1, 0, 3}}).empty());
  CHECK(message({{0, 1, 2}, {0, 1, 3}}).find("several triangles on the same side") != std::string::npos);
  CHECK(message({{0, 1, 2}, {0, 3, 4}}).find("share no edge") != std::string::npos);
  CHECK(message({{0, 1, 1}}).find("twice") != std::string::npos);
  CHECK_THROWS_AS(subdivide(icosahedron(), 12), SceneError);
}

}  // namespace sheaf::test_loop_subdivision
