// Decomposition, interpolation and composition of transforms that change over time.
#include "core/math/animated_transform.h"

#include "core/io/error.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace sheaf::test_animated_transform {

namespace {

double largest_difference(const Transform& a, const Transform& b) {
  double largest = 0;
  for (std::size_t r = 0; r < 4; ++r)
    for (std::size_t c = 0; c < 4; ++c) largest = std::max(largest, std::fabs(a.matrix().m[r][c] - b.matrix().m[r][c]));
  return largest;
}

/// Random affine transforms, half of which reflect.
Transform random_transform(std::mt19937& random) {
  std::normal_distribution<double> normal;
  Matrix4 m;
  for (std::size_t r = 0; r < 3; ++r)
    for (std::size_t c = 0; c < 4; ++c) m.m[r][c] = normal(random);
  return Transform(m);
}

}  // namespace

TEST_CASE("animated transforms: the factors multiply to the matrix, and the rotation is one") {
  std::mt19937 random(3);
  for (int i = 0; i < 1000; ++i) {
    const Transform m = random_transform(random);
    const DecomposedTransform parts = decompose(m);
    CHECK(largest_difference(compose(parts), m) < 1e-9);
    const Quaternion& q = parts.rotation;
    CHECK(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w == near(1));
    for (std::size_t r = 0; r < 3; ++r)
      for (std::size_t c = 0; c < r; ++c) CHECK(std::fabs(parts.stretch[r][c] - parts.stretch[c][r]) < 1e-9);
  }
}

TEST_CASE("animated transforms: half of a quarter turn is an eighth of a turn") {
  const AnimatedTransform azimuth({{2, Transform::rotate({0, 0, 1}, 90)}, {0, Transform()}});
  CHECK(largest_difference(azimuth.at(1), Transform::rotate({0, 0, 1}, 45)) < 1e-9);
  CHECK(largest_difference(azimuth.at(0.5), Transform::rotate({0, 0, 1}, 22.5)) < 1e-9);
}

TEST_CASE("animated transforms: rotations take the shorter arc") {
  const AnimatedTransform azimuth({{0, Transform::rotate({0, 1, 0}, -100)}, {1, Transform::rotate({0, 1, 0}, 100)}});
  CHECK(largest_difference(azimuth.at(0.5), Transform::rotate({0, 1, 0}, 180)) < 1e-9);
}

TEST_CASE("animated transforms: translation and stretch are linear") {
  const AnimatedTransform moving(
      {{0, Transform::scale({1, 2, 3})}, {4, Transform::translate({8, 0, 4}) * Transform::scale({3, 2, 7})}});
  const Transform expected = Transform::translate({2, 0, 1}) * Transform::scale({1.5f, 2, 4});
  CHECK(largest_difference(moving.at(1), expected) < 1e-9);
}

TEST_CASE("animated transforms: keys hold at their times and beyond the ends") {
  std::mt19937 random(4);
  std::vector<AnimatedTransform::Key> keys;
  for (const double time : {3.0, -1.0, 0.5}) keys.push_back({time, random_transform(random)});
  const AnimatedTransform moving(keys);
  for (const auto& key : keys) CHECK(largest_difference(moving.at(key.time), key.value) < 1e-9);
  CHECK(largest_difference(moving.at(99), keys[0].value) < 1e-9);
  CHECK(largest_difference(moving.at(-99), keys[1].value) < 1e-9);
  CHECK(largest_difference(moving.reference(), keys[1].value) < 1e-9);
  CHECK(moving.key_times() == std::vector<double>{-1, 0.5, 3});
}

TEST_CASE("animated transforms: a product interpolates each factor by itself") {
  const AnimatedTransform lift({{0, Transform()}, {1, Transform::translate({0, 2, 0})}});
  const AnimatedTransform azimuth({{0, Transform()}, {2, Transform::rotate({0, 0, 1}, 180)}});
  const Transform fixed = Transform::translate({1, 0, 0});
  const AnimatedTransform both = lift * azimuth * AnimatedTransform(fixed);
  const Transform expected =
      Transform::translate({0, 1, 0}) * Transform::rotate({0, 0, 1}, 45) * Transform::translate({1, 0, 0});
  CHECK(largest_difference(both.at(0.5), Transform::translate({0, 1, 0}) * Transform::rotate({0, 0, 1}, 45) * fixed) <
        1e-9);
  CHECK(largest_difference(both.at(0.5), expected) < 1e-9);
  CHECK(both.key_times() == std::vector<double>{0, 1, 2});
}

TEST_CASE("animated transforms: a transform without keys does not move") {
  const Transform shift = Transform::translate({1, 2, 3});
  const AnimatedTransform still =
      AnimatedTransform(shift) *
      AnimatedTransform(std::vector<AnimatedTransform::Key>{{7, Transform::scale({2, 2, 2})}});
  CHECK_FALSE(still.moves());
  CHECK(still.key_times().empty());
  CHECK(largest_difference(still.at(5), shift * Transform::scale({2, 2, 2})) < 1e-12);
  CHECK_FALSE(AnimatedTransform().moves());
  CHECK(largest_difference(AnimatedTransform().at(0), Transform()) == 0);
}

TEST_CASE("animated transforms: wrong keys are errors") {
  CHECK_THROWS_AS(AnimatedTransform(std::vector<AnimatedTransform::Key>{}), SceneError);
  CHECK_THROWS_AS(AnimatedTransform({{1, Transform()}, {1, Transform()}}), SceneError);
  CHECK_THROWS_AS(AnimatedTransform({{std::nan(""), Transform()}}), SceneError);
  // Half way between a transform and its mirror image nothing is left of the mirrored axis
  const AnimatedTransform mirror({{0, Transform()}, {1, Transform::scale({-1, -1, -1})}});
  CHECK_THROWS_AS(mirror.at(0.5), SceneError);
}

}  // namespace sheaf::test_animated_transform
