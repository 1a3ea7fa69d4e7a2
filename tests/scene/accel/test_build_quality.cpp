// The measure that selects the quality of the BVH build.
#include "scene/accel/build_quality.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

#include <cmath>
#include <vector>

namespace sheaf::test_build_quality {

namespace {

/// A shape made of triangles.
struct Triangles {
  std::vector<VertexRow> vertices;
  std::vector<std::uint32_t> indices;
  ShapeRow shape{};

  void add(Vec3f a, Vec3f b, Vec3f c) {
    for (const Vec3f p : {a, b, c}) {
      VertexRow row{};
      row.position = p;
      indices.push_back(static_cast<std::uint32_t>(vertices.size()));
      vertices.push_back(row);
    }
  }
  double waste() {
    shape.kind = static_cast<std::uint32_t>(ShapeKind::kMesh);
    shape.triangle_count = static_cast<std::uint32_t>(indices.size() / 3);
    AccelInput in{};
    in.shapes = &shape;
    in.vertices = vertices.data();
    in.triangles = indices.data();
    return wasted_boxes(in, {0, 1});
  }
};

}  // namespace

TEST_CASE("box waste: half of a box of axis-aligned flat triangles is wasted and more of slanted ones") {
  // Two halves of a square: its box counts twice, the halves together once.
  Triangles square;
  square.add({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  square.add({1, 1, 0}, {1, 0, 0}, {0, 1, 0});
  CHECK(square.waste() == near(1));
  // A needle through a cube from corner to corner: its box is the whole cube.
  Triangles needles;
  for (int i = 0; i < 10; ++i) needles.add({0, 0, 0}, {1, 1, 1}, {1e-4f, 0, 0});
  CHECK(needles.waste() == near(10, 1e-3));
  // The measure does not depend on the size of the scene.
  Triangles large;
  for (int i = 0; i < 10; ++i) large.add({0, 0, 0}, {1000, 1000, 1000}, {0.1f, 0, 0});
  CHECK(large.waste() == near(10, 1e-3));
  CHECK(Triangles{}.waste() == 0);
}

TEST_CASE("box waste: a fine mesh is not worth spatial splits but long needles across it are") {
  Triangles mesh;
  constexpr int kSide = 40;
  const auto point = [](int i, int k) {
    const float x = static_cast<float>(i) / kSide, y = static_cast<float>(k) / kSide;
    return Vec3f{x, y, 0.2f * std::sin(6 * x) * std::cos(5 * y)};
  };
  for (int i = 0; i < kSide; ++i)
    for (int k = 0; k < kSide; ++k) {
      mesh.add(point(i, k), point(i + 1, k), point(i, k + 1));
      mesh.add(point(i + 1, k + 1), point(i + 1, k), point(i, k + 1));
    }
  const double smooth = mesh.waste();
  for (int i = 0; i < 20; ++i) {
    const float x = static_cast<float>(i) / 20;
    mesh.add({x, 0, -0.2f}, {1 - x, 1, 0.2f}, {x + 0.01f, 0, -0.2f});
  }
  const double crossed = mesh.waste();
  CHECK(smooth < 3);
  CHECK(crossed > smooth + 5);
}

}  // namespace sheaf::test_build_quality
