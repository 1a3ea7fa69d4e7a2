// Transforms for tests of shapes.
#pragma once

#include "core/math/transform.h"

#include <vector>

namespace sheaf {

/// Similarities, non-uniform scalings, shears and a mirror.
inline std::vector<Transform> test_transforms() {
  Matrix4 shear;
  shear.m[0][1] = 0.7;
  shear.m[2][0] = -0.4;
  return {Transform(),
          Transform::translate({3, -2, 1}) * Transform::rotate({1, 2, 3}, 50) * Transform::scale({2, 2, 2}),
          Transform::translate({-1, 0, 2}) * Transform::rotate({0, 1, 1}, -70) * Transform::scale({0.3f, 1.5f, 2.5f}),
          Transform::scale({1, -2, 0.5f}) * Transform(shear)};
}

}  // namespace sheaf
