// Rows and bounds of instances.
#include "scene/tables/instance.h"

#include "core/io/error.h"

#include <cmath>

namespace sheaf {

InstanceRow make_instance(const std::array<float, 12>& to_world, std::uint32_t first_shape, std::uint32_t group) {
  if (!is_usable_instance(to_world)) throw SceneError("the transform of an instance is singular or too extreme");
  InstanceRow row{};
  std::copy(to_world.begin(), to_world.end(), row.to_world);
  row.determinant = static_cast<float>(determinant_of(to_world));
  row.first_shape = first_shape;
  row.group = group;
  return row;
}

Bounds3f instance_bounds(const InstanceRow& row, const Bounds3f& box) {
  const double low[3] = {box.min.x, box.min.y, box.min.z}, high[3] = {box.max.x, box.max.y, box.max.z};
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
