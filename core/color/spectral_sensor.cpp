// Tabulation of the responses of the sensor.
#include "core/color/spectral_sensor.h"

#include "core/color/color.h"

namespace sheaf {

SensorCurves::SensorCurves() : rgb{} {
  constexpr float kStep = 5.0f;
  double y = 0;  // y is linear between nodes, so the trapezoidal rule gives its integral
  for (int i = 0; i < kNodes; ++i) {
    const float lambda = kWavelengthMin + kStep * static_cast<float>(i);
    const double half = i == 0 || i == kNodes - 1 ? 0.5 : 1.0;
    y += half * static_cast<double>(kStep) * static_cast<double>(cie_1931_xyz(lambda).y);
    const Vec3f response = xyz_to_rec709(cie_1931_xyz(lambda));
    rgb[i][0] = response.x, rgb[i][1] = response.y, rgb[i][2] = response.z;
  }
  const float per_y = static_cast<float>(1.0 / y);
  for (auto& node : rgb)
    for (float& channel : node) channel *= per_y;
}

const SensorCurves& SensorCurves::get() {
  static const SensorCurves curves;
  return curves;
}

}  // namespace sheaf
