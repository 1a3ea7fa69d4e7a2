// Bounds of lights contain everything that sample_light() finds, and the light tree never misses such light.
#include "scene/lights/light_bounds.h"

#include "kernels/lights/light_tree.h"
#include "scene/accel/quadric.h"
#include "scene/compile/compile.h"
#include "scene/lights/light_powers.h"
#include "tests/support/light_testing.h"
#include "tests/support/near.h"
#include "tests/support/records_testing.h"
#include "tests/support/tiny_scenes.h"

#include <doctest/doctest.h>

#include <cmath>
#include <memory>
#include <vector>

namespace sheaf::test_light_bounds {

namespace {

const Transform kTilt = Transform::translate({0.3f, -0.2f, 3}) * Transform::rotate({1, 2, 0.5f}, 155);

/// An open mesh of triangles in planes up to about 60 degrees apart.
Mesh roof() {
  Mesh mesh;
  mesh.positions = {{-1, -1, 0}, {1, -1, 0.2f}, {-1, 1, 0.1f}, {1.5f, 1.2f, -0.6f}, {1.6f, 1.0f, -0.9f}};
  mesh.triangles = {{0, 1, 2}, {2, 1, 3}, {3, 1, 4}};
  return mesh;
}

/// Samples of lone lights at points all around them, against their bounds.
struct Tally {
  int arriving = 0, missed = 0, outside = 0, unlit = 0;
};
template <class Geometry>
Tally tally(Geometry geometry, const Transform& to_world, bool flip, bool both_sides = false) {
  Description d = empty_scene(4, 4);
  ShapeDescription& shape = emit(add_shape(d, std::move(geometry), to_world), 1);
  shape.flip_normals = flip;
  shape.emits_on_both_sides = both_sides;
  const std::unique_ptr<Scene> owner = compile_scene(d);
  const SceneView scene = owner->view();
  const LightBounds bounds = bounds_of_light(scene, 0, scene.lights.powers[0].x);
  const LightTree tree = build_light_tree(std::vector<LightBounds>{bounds});
  Tally out;
  for (std::uint32_t i = 0; i < 20000; ++i) {
    const auto u = lane_random(3, i, 0);
    const Vec3f middle = (bounds.lower + bounds.upper) * 0.5f;
    const float distances[] = {0.1f, 1, 3, 100};
    const Vec3f p = middle + square_to_sphere<Scalar>(u.x, u.y) * distances[i % 4];
    const bool chosen = light_tree_probability<Scalar>(tree.view(), p, {}, false, 0, true) > 0;
    out.unlit += !chosen;
    const auto s = sample_any_light<Scalar>(scene, p, lane_random(4, i, 0));
    if (!s.valid) continue;
    ++out.arriving;
    out.missed += !chosen;
    const float slack = 1e-3f;
    const Vec3f below = bounds.lower - s.target, above = s.target - bounds.upper;
    out.outside += max_component(below) > slack || max_component(above) > slack;
  }
  return out;
}

}  // namespace

TEST_CASE("light bounds: every kind of shape emits only within its bounds") {
  for (const bool flip : {false, true}) {
    const Tally tallies[] = {tally(roof(), kTilt, flip),
                             tally(SphereShape{}, kTilt, flip),
                             tally(SphereShape{}, kTilt * Transform::scale({1, 2, 0.3f}), flip),
                             tally(DiskShape{}, kTilt, flip),
                             tally(DiskShape{}, kTilt * Transform::scale({-1, 2, 0.3f}), flip),
                             tally(CylinderShape{}, kTilt, flip)};
    for (const Tally& t : tallies) {
      CHECK(t.arriving > 1000);
      CHECK(t.missed == 0);
      CHECK(t.outside == 0);
    }
    // Flat and nearly flat lights leave much of space dark.
    CHECK(tallies[0].unlit > 500);
    CHECK(tallies[3].unlit > 3000);
    CHECK(tallies[4].unlit > 3000);
  }
}

TEST_CASE("light bounds: two-sided lights emit to both sides and are bounded so") {
  const Tally tallies[] = {tally(roof(), kTilt, false, true),
                           tally(RectangleShape{}, kTilt, false, true),
                           tally(RectangleShape{}, kTilt, true, true),
                           tally(DiskShape{}, kTilt * Transform::scale({-1, 2, 0.3f}), false, true),
                           tally(SphereShape{}, kTilt * Transform::scale({1, 2, 0.3f}), false, true),
                           tally(CylinderShape{}, kTilt, true, true)};
  for (const Tally& t : tallies) {
    CHECK(t.arriving > 15000);
    CHECK(t.missed == 0);
    CHECK(t.outside == 0);
  }
}

TEST_CASE("light bounds: the power is pi times the intensity in the brightest direction") {
  LightTriangleRow row{};
  row.edge1.x = 2;
  row.edge2.y = 3;
  row.normal.z = 1;
  CHECK(mesh_light_bounds(std::vector<LightTriangleRow>{row}, 5).power == near(kPi * 5 * 3));
  // Two faces back to back are not brighter than one.
  LightTriangleRow back = row;
  back.normal.z = -1;
  std::swap(back.edge1, back.edge2);
  CHECK(mesh_light_bounds(std::vector<LightTriangleRow>{row, back}, 5).power == near(kPi * 5 * 3));
  CHECK(mesh_light_bounds(std::vector<LightTriangleRow>{row, back}, 5).cos_theta_o == near(-1));

  const Transform doubled = Transform::scale({2, 2, 2});
  const auto power_of = [&](ShapeKind kind) {
    return quadric_light_bounds(make_quadric(kind, doubled, false), 3).power;
  };
  CHECK(power_of(ShapeKind::kSphere) == near(kPi * 3 * kPi * 4));
  CHECK(power_of(ShapeKind::kDisk) == near(kPi * 3 * kPi * 4));
  CHECK(power_of(ShapeKind::kCylinder) == near(kPi * 3 * 8));
  CHECK(point_light_bounds({1, 2, 3}, 7).power == near(kPi * 7));
  CHECK(spot_light_bounds({1, 2, 3}, {0, 0, 1}, 0.5f, 7).power == near(kPi * 7));
}

TEST_CASE("light bounds: a spot light is chosen inside its cone only") {
  for (const float cos_total : {0.999f, 0.7f, 0.0f, -0.5f}) {
    const Vec3f axis = normalize(Vec3f{1, 2, -1});
    const LightBounds spot = spot_light_bounds({3, 2, 1}, axis, cos_total, 2);
    const LightTree tree = build_light_tree(std::vector<LightBounds>{spot});
    int missed = 0, wasted = 0, inside = 0;
    for (std::uint32_t i = 0; i < 20000; ++i) {
      const auto u = lane_random(5, i, 0);
      const Vec3f around = square_to_sphere<Scalar>(u.x, u.y);
      const Vec3f w = i % 2 == 0 ? around : normalize(axis + around * 0.06f);
      const bool lit = dot(w, axis) > cos_total;
      const Vec3f p = spot.lower + w * 50.0f;
      const bool chosen = light_tree_probability<Scalar>(tree.view(), p, {}, false, 0, true) > 0;
      inside += lit;
      missed += lit && !chosen;
      // Beyond a right angle, the end of the cone is less exact, and at a right angle 1 - cosine is rounded most.
      const float slack = cos_total < 0 ? 0.1f : cos_total == 0 ? 0.01f : 0.005f;
      wasted += chosen && std::acos(dot(w, axis)) > std::acos(cos_total) + slack;
    }
    CHECK(inside > 1000);
    CHECK(missed == 0);
    CHECK(wasted == 0);
  }
}

TEST_CASE("light bounds: empty and degenerate meshes have valid bounds") {
  const LightBounds empty = mesh_light_bounds({}, 1);
  CHECK(empty.power > 0);
  LightTriangleRow sliver{};
  sliver.edge1.x = sliver.edge2.x = 1;
  const LightBounds no_area = mesh_light_bounds(std::vector<LightTriangleRow>{sliver}, 1);
  const LightTree tree = build_light_tree(std::vector<LightBounds>{empty, no_area});
  CHECK(tree.nodes.size() == 1);
}

}  // namespace sheaf::test_light_bounds
