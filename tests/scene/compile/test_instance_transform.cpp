// Limits on the transforms of instances.
#include "core/math/transform.h"
#include "scene/tables/instance_transform.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace sheaf::test_instance_transform {

namespace {

/// The definition of is_usable_instance().
bool is_within_limits(const std::array<float, 12>& rows) {
  Matrix4 matrix, inverse;
  double largest = 0;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) {
      matrix.m[i][j] = rows[4 * i + j];
      largest = std::max(largest, std::fabs(matrix.m[i][j]));
    }
  if (determinant_of(rows) == 0.0 || !invert(matrix, inverse)) return false;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) largest = std::max(largest, std::fabs(inverse.m[i][j]));
  return largest <= kLargestInstanceScale;
}

}  // namespace

TEST_CASE("instance transforms: entries of the matrix and of its inverse are limited") {
  const auto scaled = [](float x, float y, float z) {
    return std::array<float, 12>{x, 0, 0, 1, 0, y, 0, 2, 0, 0, z, 3};
  };
  for (const float limit : {1e9f, 2e-9f}) CHECK(is_usable_instance(scaled(1, limit, -1)));
  for (const float limit : {2e9f, 0.5e-9f, 0.0f}) CHECK_FALSE(is_usable_instance(scaled(1, limit, -1)));
  for (const float value : {std::numeric_limits<float>::quiet_NaN(), kInfinity})
    for (std::size_t i = 0; i < 12; ++i) {
      std::array<float, 12> rows = scaled(1, 2, 3);
      rows[i] = value;
      CHECK_FALSE(is_usable_instance(rows));
    }
}

TEST_CASE("instance transforms: the limits hold for sheared, scaled and nearly singular matrices") {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> uniform(-1, 1);
  int usable = 0;
  constexpr int kCount = 20'000;
  for (int n = 0; n < kCount; ++n) {
    std::array<float, 12> rows{};
    const float near_singular = std::pow(10.0f, 6 * uniform(random) - 6),
                size = std::pow(10.0f, 9.5f * uniform(random));
    for (std::size_t j = 0; j < 3; ++j) {
      rows[j] = uniform(random) * size;
      rows[4 + j] = uniform(random) * size;
      rows[8 + j] = rows[j] + near_singular * uniform(random) * size;
    }
    const bool expected = is_within_limits(rows);
    usable += expected ? 1 : 0;
    CHECK(is_usable_instance(rows) == expected);
  }
  CHECK(usable > kCount / 5);
  CHECK(usable < 4 * kCount / 5);
}

}  // namespace sheaf::test_instance_transform
