// Transforms: inverses, composition, normals, look-at.
#include "core/math/transform.h"

#include "core/io/error.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

#include <limits>
#include <vector>

namespace sheaf::test_transform {

namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

void check_near(Vec3f a, Vec3f b, double tolerance = 1e-5) {
  CAPTURE(a.x);
  CAPTURE(a.y);
  CAPTURE(a.z);
  CHECK(length(a - b) <= tolerance * std::max(1.0f, length(b)));
}

/// Rotation, non-uniform scaling, mirroring, translation, shear.
std::vector<Transform> transforms() {
  const Transform t = Transform::translate({1, -2, 3}), s = Transform::scale({2, 0.5f, 4}),
                  r = Transform::rotate({1, 2, 3}, 77);
  const Transform mirror = Transform::scale({1, -1, 1});
  Matrix4 shear;
  shear.m[0][1] = 0.7;
  shear.m[2][0] = -1.3;
  return {Transform(),
          t,
          s,
          r,
          t * r,
          r * s * t,
          mirror * r * s,
          Transform(shear) * t,
          Transform::look_at({4, 5, 6}, {0, 1, 0}, {0, 1, 0}),
          Transform::scale({1e-3f, 1e-3f, 1e-3f}) * t};
}

}  // namespace

TEST_CASE("transform: the inverse restores points and vectors") {
  const Vec3f p{0.3f, -1.7f, 2.2f};
  for (const Transform& t : transforms()) {
    check_near(t.inverse().point(t.point(p)), p);
    check_near(t.point(t.inverse().point(p)), p);
    check_near(t.inverse().vector(t.vector(p)), p);
    const Matrix4 product = t.matrix() * t.inverse_matrix();
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) CHECK(std::fabs(product.m[i][j] - (i == j ? 1.0 : 0.0)) < 1e-9);
  }
}

TEST_CASE("transform: composition applies the right one first and composes inverses") {
  const Vec3f p{0.3f, -1.7f, 2.2f};
  for (const Transform& a : transforms())
    for (const Transform& b : transforms()) {
      check_near((a * b).point(p), a.point(b.point(p)));
      check_near((a * b).vector(p), a.vector(b.vector(p)));
      check_near((a * b).inverse().point(p), b.inverse().point(a.inverse().point(p)));
    }
}

TEST_CASE("transform: elementary transforms have the expected effect on points") {
  CHECK(Transform::translate({1, 2, 3}).point({1, 1, 1}) == Vec3f{2, 3, 4});
  CHECK(Transform::translate({1, 2, 3}).vector({1, 1, 1}) == Vec3f{1, 1, 1});
  CHECK(Transform::scale({1, 2, 3}).point({1, 1, 1}) == Vec3f{1, 2, 3});
  check_near(Transform::rotate({0, 0, 5}, 90).point({1, 0, 0}), {0, 1, 0}, 1e-6);
  check_near(Transform::rotate({1, 0, 0}, 90).point({0, 1, 0}), {0, 0, 1}, 1e-6);
  check_near(Transform::rotate({0, 1, 0}, 90).point({0, 0, 1}), {1, 0, 0}, 1e-6);
  check_near(Transform::rotate({1, 1, 1}, 120).point({1, 0, 0}), {0, 1, 0}, 1e-6);
  check_near(Transform::rotate({1, 2, 3}, 360).point({4, 5, 6}), {4, 5, 6}, 1e-6);
}

TEST_CASE("transform: normals stay perpendicular to surfaces") {
  const Vec3f n{0.2f, 0.7f, -0.4f}, tangent = cross(n, Vec3f{1, 0, 0}), bitangent = cross(n, tangent);
  for (const Transform& t : transforms()) {
    const Vec3f m = normalize(t.normal(n));
    CHECK(std::fabs(dot(m, normalize(t.vector(tangent)))) < 1e-5f);
    CHECK(std::fabs(dot(m, normalize(t.vector(bitangent)))) < 1e-5f);
    CHECK(dot(m, t.vector(n)) > 0.0f);
  }
}

TEST_CASE("transform: mirroring transforms are recognized by their determinant") {
  CHECK_FALSE(Transform().swaps_handedness());
  CHECK_FALSE(Transform::rotate({3, 1, 2}, 200).swaps_handedness());
  CHECK_FALSE(Transform::look_at({1, 2, 3}, {0, 0, 0}, {0, 1, 0}).swaps_handedness());
  CHECK(Transform::scale({-1, 1, 1}).swaps_handedness());
  CHECK_FALSE(Transform::scale({-1, -1, 1}).swaps_handedness());
  CHECK(Transform::scale({-1, -2, -3}).swaps_handedness());
}

TEST_CASE("transform: a projective matrix divides points by w") {
  Matrix4 m;
  m.m[3] = {0, 0, 1, 0};
  m.m[2] = {0, 0, 0, 1};
  CHECK(Transform(m).point({2, 4, 2}) == Vec3f{1, 2, 0.5f});
}

TEST_CASE("transform: look_at faces the target upright with x to the left") {
  const Transform t = Transform::look_at({1, 2, 3}, {1, 2, 10}, {0, 1, 0});
  check_near(t.point({0, 0, 0}), {1, 2, 3});
  check_near(t.vector({0, 0, 1}), {0, 0, 1});
  check_near(t.vector({0, 1, 0}), {0, 1, 0});
  check_near(t.vector({1, 0, 0}), {1, 0, 0});
  const Transform oblique = Transform::look_at({5, 1, -2}, {-1, 0, 3}, {0.1f, 3, 0.2f});
  const Vec3f dir = oblique.vector({0, 0, 1}), up = oblique.vector({0, 1, 0}), left = oblique.vector({1, 0, 0});
  check_near(dir, normalize(Vec3f{-6, -1, 5}));
  CHECK(std::fabs(dot(dir, up)) < 1e-6f);
  CHECK(length(up) == near(1.0));
  CHECK(dot(up, Vec3f{0.1f, 3, 0.2f}) > 0.0f);
  check_near(left, cross(up, dir));
}

TEST_CASE("transform: look_at works at every scale and rejects degenerate directions") {
  for (const float scale : {1e-30f, 1e-10f, 1.0f, 1e10f, 1e30f}) {
    CAPTURE(scale);
    const Transform t = Transform::look_at({scale, 0, 0}, {scale, 0, -scale}, {0, scale, 0});
    check_near(t.vector({0, 0, 1}), {0, 0, -1});
    check_near(t.vector({1, 0, 0}), {-1, 0, 0});
  }
  CHECK_THROWS_AS(Transform::look_at({1, 2, 3}, {1, 2, 3}, {0, 1, 0}), SceneError);
  CHECK_THROWS_AS(Transform::look_at({0, 0, 0}, {0, 2, 0}, {0, 1, 0}), SceneError);
  CHECK_THROWS_AS(Transform::look_at({0, 0, 0}, {0, 2, 0}, {0, 0, 0}), SceneError);
  CHECK_THROWS_AS(Transform::look_at({0, kNaN, 0}, {0, 2, 0}, {0, 0, 1}), SceneError);
  CHECK_THROWS_AS(Transform::look_at({0, 0, 0}, {0, kInfinity, 0}, {0, 0, 1}), SceneError);
}

TEST_CASE("transform: singular matrices are rejected") {
  CHECK_THROWS_AS(Transform::scale({1, 0, 1}), SceneError);
  CHECK_THROWS_AS(Transform::scale({1, kNaN, 1}), SceneError);
  CHECK_THROWS_AS(Transform::scale({1, kInfinity, 1}), SceneError);
  CHECK_THROWS_AS(Transform::rotate({0, 0, 0}, 30), SceneError);
  CHECK_THROWS_AS(Transform::rotate({0, 0, 1}, std::numeric_limits<double>::quiet_NaN()), SceneError);
  CHECK_THROWS_AS(Transform::translate({kInfinity, 0, 0}), SceneError);
  const double inf = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j)
      for (const double bad : {inf, -inf, std::numeric_limits<double>::quiet_NaN()}) {
        Matrix4 m;
        m.m[i][j] = bad;
        CHECK_THROWS_AS(Transform{m}, SceneError);
      }
  Matrix4 dependent;
  dependent.m[1] = dependent.m[0];
  Matrix4 out;
  CHECK_FALSE(invert(dependent, out));
}

TEST_CASE("transform: inversion uses pivoting") {
  Matrix4 swapped;
  swapped.m = {{{0, 1, 0, 5}, {1, 0, 0, 6}, {0, 0, 0, 1}, {0, 0, 1, 0}}};
  Matrix4 inverse;
  REQUIRE(invert(swapped, inverse));
  const Matrix4 product = swapped * inverse;
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) CHECK(product.m[i][j] == near(i == j ? 1.0 : 0.0));
}

}  // namespace sheaf::test_transform
