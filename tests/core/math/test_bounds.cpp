// Axis-aligned boxes: growth, emptiness and intersection.
#include "core/math/bounds.h"

#include <doctest/doctest.h>

namespace sheaf::test_bounds {

TEST_CASE("bounds: a box grows to contain points and boxes") {
  Bounds3f box = Bounds3f::empty();
  CHECK(box.is_empty());
  box.grow(Vec3f{1, -2, 3});
  CHECK_FALSE(box.is_empty());
  CHECK(box.min == box.max);
  box.grow({{-1, 0, 0}, {0, 5, 1}});
  CHECK(box.min == Vec3f{-1, -2, 0});
  CHECK(box.max == Vec3f{1, 5, 3});
  CHECK(box.corner(0) == box.min);
  CHECK(box.corner(5) == Vec3f{1, -2, 3});
  const Bounds3f before = box;
  box.grow(Bounds3f::empty());
  CHECK(box.min == before.min);
  CHECK(box.max == before.max);
}

TEST_CASE("bounds: intersections are empty unless the boxes overlap along all axes") {
  const Bounds3f unit{{0, 0, 0}, {1, 1, 1}};
  const Bounds3f common = intersection(unit, {{0.5f, -1, 0.25f}, {2, 2, 0.75f}});
  CHECK(common.min == Vec3f{0.5f, 0, 0.25f});
  CHECK(common.max == Vec3f{1, 1, 0.75f});
  CHECK_FALSE(intersection(unit, {{1, 1, 1}, {2, 2, 2}}).is_empty());
  CHECK(intersection(unit, {{1.5f, 0, 0}, {2, 1, 1}}).is_empty());
  CHECK(intersection(unit, {{0, 1.5f, 0}, {1, 2, 1}}).is_empty());
  CHECK(intersection(unit, {{0, 0, 1.5f}, {1, 1, 2}}).is_empty());
}

}  // namespace sheaf::test_bounds
