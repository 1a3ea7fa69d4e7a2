// The quality of the BVH build: waste of boxes, and spatial splits that the rays repay.
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

namespace {

using Builds = std::vector<BvhBuild>;
using enum BvhBuild;

/// Needles through a cube as the shapes outside of groups, and as two groups with instances.
struct Structures {
  static constexpr std::uint32_t kTriangles = 30'000;  // of each structure
  Triangles needles;
  std::vector<ShapeRow> shapes;
  std::vector<ShapeRange> groups{{1, 1}, {2, 1}};
  std::vector<InstanceRow> instances;
  AccelInput in{};

  /// `copies`: number of instances of the groups.
  Structures(std::uint32_t first_copies, std::uint32_t second_copies) {
    for (std::uint32_t i = 0; i < kTriangles; ++i) needles.add({0, 0, 0}, {1, 1, 1}, {1e-4f, 0, 0});
    ShapeRow row{};
    row.kind = static_cast<std::uint32_t>(ShapeKind::kMesh);
    row.triangle_count = kTriangles;
    shapes.assign(3, row);
    instances.resize(first_copies + second_copies);
    for (std::uint32_t i = 0; i < instances.size(); ++i) instances[i].group = i < first_copies ? 0 : 1;
    in.shapes = shapes.data();
    in.shape_count = 1;
    in.vertices = needles.vertices.data();
    in.triangles = needles.indices.data();
    in.groups = groups.data();
    in.group_count = 2;
    in.instances = instances.data();
    in.instance_count = first_copies + second_copies;
  }
  /// The result for this number of rays per triangle of one structure.
  BuildChoice choose(double rays) const { return choose_builds(in, rays * kTriangles); }
};

}  // namespace

TEST_CASE("splits: built by structures whose rays repay them") {
  const Structures scene(9, 1);
  for (const double many : {double(kInfinity), 3.0 * 30}) {
    CHECK(scene.choose(many).builds == Builds{kSpatial, kSpatial, kSpatial});
    CHECK(scene.choose(many).splits == BvhSplits::kBuilt);
  }
  // An object with more instances meets more rays
  CHECK(scene.choose(35).builds == Builds{kSpatial, kSpatial, kSurface});
  CHECK(scene.choose(31).builds == Builds{kSpatial, kSurface, kSurface});
  CHECK(scene.choose(29).builds == Builds{kSurface, kSurface, kSurface});
  CHECK(scene.choose(35).splits == BvhSplits::kLeftOut);
}

TEST_CASE("builds: structures that meet very few rays are built along a Morton curve, and small ones never") {
  Structures scene(9, 1);
  CHECK(scene.choose(0).builds == Builds{kMorton, kMorton, kMorton});
  CHECK(scene.choose(0).splits == BvhSplits::kLeftOut);
  CHECK(scene.choose(2.1).builds == Builds{kSurface, kMorton, kMorton});
  CHECK(scene.choose(2.3).builds == Builds{kSurface, kSurface, kMorton});
  CHECK(scene.choose(21).builds == Builds{kSurface, kSurface, kSurface});
  scene.shapes[1].triangle_count = 9999;
  CHECK(scene.choose(0).builds == Builds{kMorton, kSurface, kMorton});
  // Nor those of many small meshes
  scene.in.shape_count = 3;
  scene.in.group_count = scene.in.instance_count = 0;
  for (ShapeRow& shape : scene.shapes) shape.triangle_count = 4000;
  CHECK(scene.choose(0).builds == Builds{kMorton});
  scene.shapes[2].triangle_count = 3900;
  CHECK(scene.choose(0).builds == Builds{kSurface});
}

TEST_CASE("splits: built by small scenes for any number of rays, and not by meshes without waste") {
  Structures scene(1, 1);
  for (ShapeRow& shape : scene.shapes) shape.triangle_count = 3000;
  CHECK(scene.choose(0).builds == Builds{kSpatial, kSpatial, kSpatial});
  for (ShapeRow& shape : scene.shapes) shape.triangle_count = 3;
  CHECK(scene.choose(1e9).builds == Builds{kSurface, kSurface, kSurface});
  CHECK(scene.choose(1e9).splits == BvhSplits::kNotNeeded);
}

}  // namespace sheaf::test_build_quality
