#include "scene/tables/instance_transform.h"

#include "core/math/transform.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace sheaf {

namespace {

/// Inverse of the linear part, in double precision; empty if it is singular.
std::optional<Matrix4> inverse_of(const std::array<float, 12>& to_world) {
  Matrix4 matrix, inverse;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) matrix.m[i][j] = to_world[4 * i + j];
  return invert(matrix, inverse) ? std::optional(inverse) : std::nullopt;
}

}  // namespace

std::array<float, 12> rounded_rows(const std::array<double, 12>& to_world) {
  std::array<float, 12> rows;
  for (std::size_t i = 0; i < 12; ++i) rows[i] = static_cast<float>(to_world[i]);
  return rows;
}

double determinant_of(const std::array<float, 12>& m) {
  const auto minor = [&m](std::size_t i, std::size_t j) {
    return double(m[4 + i]) * m[8 + j] - double(m[4 + j]) * m[8 + i];
  };
  return m[0] * minor(1, 2) - m[1] * minor(0, 2) + m[2] * minor(0, 1);
}

bool is_usable_instance(const std::array<float, 12>& to_world) {
  double largest = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      const double size = std::fabs(double{to_world[4 * i + j]});
      if (!(size <= kLargestInstanceScale)) return false;  // also for NaN
      largest = std::max(largest, size);
    }
    if (!std::isfinite(to_world[4 * i + 3])) return false;
  }
  // The inverse has no entry above 2 largest^2 / |det|. Well below the limit, this bound suffices
  const double determinant = std::fabs(determinant_of(to_world));
  constexpr double kMargin = 1e-3, kMinConditioning = 1e-6;
  if (2 * largest * largest <= kMargin * kLargestInstanceScale * determinant &&
      determinant >= kMinConditioning * largest * largest * largest)
    return true;
  const std::optional<Matrix4> inverse = inverse_of(to_world);
  if (!inverse || determinant == 0.0) return false;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      if (!(std::fabs(inverse->m[i][j]) <= kLargestInstanceScale)) return false;
  return true;
}

}  // namespace sheaf
