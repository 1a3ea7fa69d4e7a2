// Rows of instances, from their transforms.
#include "scene/instance.h"

#include <cmath>

namespace sheaf {

namespace {

/// The linear part as a transform with inverse in double precision; nothing if it is singular.
std::optional<Matrix4> inverse_of(const std::array<float, 12>& to_world) {
  Matrix4 matrix, inverse;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) matrix.m[i][j] = to_world[4 * i + j];
  return invert(matrix, inverse) ? std::optional(inverse) : std::nullopt;
}

double determinant_of(const std::array<float, 12>& m) {
  const auto minor = [&m](std::size_t i, std::size_t j) {
    return double(m[4 + i]) * m[8 + j] - double(m[4 + j]) * m[8 + i];
  };
  return m[0] * minor(1, 2) - m[1] * minor(0, 2) + m[2] * minor(0, 1);
}

}  // namespace

bool is_usable_instance(const std::array<float, 12>& to_world) {
  const std::optional<Matrix4> inverse = inverse_of(to_world);
  if (!inverse || determinant_of(to_world) == 0.0) return false;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      // Written so that NaN fails.
      if (!(std::fabs(to_world[4 * i + j]) <= kLargestInstanceScale)) return false;
      if (!(std::fabs(inverse->m[i][j]) <= kLargestInstanceScale)) return false;
    }
    if (!std::isfinite(to_world[4 * i + 3])) return false;
  }
  return true;
}

InstanceRow make_instance(const std::array<float, 12>& to_world, std::uint32_t first_shape, std::uint32_t group) {
  if (!is_usable_instance(to_world)) throw SceneError("the transform of an instance is singular or too extreme");
  InstanceRow row{};
  std::copy(to_world.begin(), to_world.end(), row.to_world);
  row.determinant = static_cast<float>(determinant_of(to_world));
  row.first_shape = first_shape;
  row.group = group;
  return row;
}

InstanceBounds instance_bounds(const InstanceRow& row, Vec3f lower, Vec3f upper) {
  const double low[3] = {lower.x, lower.y, lower.z}, high[3] = {upper.x, upper.y, upper.z};
  double out[2][3];
  for (int i = 0; i < 3; ++i) {
    const float* m = row.to_world + 4 * i;
    out[0][i] = out[1][i] = m[3];
    for (int j = 0; j < 3; ++j) {
      out[0][i] += std::fmin(m[j] * low[j], m[j] * high[j]);
      out[1][i] += std::fmax(m[j] * low[j], m[j] * high[j]);
    }
  }
  const auto vec = [](const double* v) {
    return Vec3f{static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2])};
  };
  return {vec(out[0]), vec(out[1])};
}

}  // namespace sheaf
