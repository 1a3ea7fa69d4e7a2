#include "scene/lights/framed_light.h"

#include <algorithm>
#include <cmath>

namespace sheaf {

std::array<double, 9> rotation_of(const Transform& to_world, const char* what, const SourceLocation& where) {
  const auto& m = to_world.matrix().m;
  double squared[3], mixed = 0;
  for (std::size_t j = 0; j < 3; ++j) {
    squared[j] = m[0][j] * m[0][j] + m[1][j] * m[1][j] + m[2][j] * m[2][j];
    const std::size_t k = (j + 1) % 3;
    mixed = std::max(mixed, std::fabs(m[0][j] * m[0][k] + m[1][j] * m[1][k] + m[2][j] * m[2][k]));
  }
  const auto [smallest, largest] = std::minmax_element(squared, squared + 3);
  constexpr double kTolerance = 1e-4;
  if (!(*smallest > 0.0) || *largest - *smallest > kTolerance * *largest || mixed > kTolerance * *largest)
    throw SceneError(where, std::string(what) + " is stretched by its transform, expected a rotation");
  std::array<double, 9> rows;
  for (std::size_t i = 0; i < 9; ++i) rows[i] = m[i % 3][i / 3] / std::sqrt(squared[i / 3]);
  return rows;
}

FramedLightData<Scalar> rotated_frame(const Transform& to_world, const char* what, const SourceLocation& where,
                                      LightContext& context) {
  const std::array<double, 9> rotation = rotation_of(to_world, what, where);
  const Vec3f origin = to_world.point({0, 0, 0});
  LightFrameRow frame;
  Vec3f* const rows[3] = {&frame.row_x, &frame.row_y, &frame.row_z};
  float* const offsets[3] = {&frame.offset_x, &frame.offset_y, &frame.offset_z};
  for (std::size_t i = 0; i < 3; ++i) {
    const double* row = rotation.data() + 3 * i;
    *rows[i] = {static_cast<float>(row[0]), static_cast<float>(row[1]), static_cast<float>(row[2])};
    *offsets[i] = static_cast<float>(-(row[0] * origin.x + row[1] * origin.y + row[2] * origin.z));
  }
  return {origin, context.add_frame(frame)};
}

}  // namespace sheaf
