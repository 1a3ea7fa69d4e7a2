#include "scene/lights/light_bounds.h"

#include <algorithm>
#include <cmath>

namespace sheaf {

float peak_power(double peak_intensity) {
  return static_cast<float>(std::clamp(double(kPi) * peak_intensity, 1e-30, 1e30));
}

LightBounds point_light_bounds(Vec3f position, float intensity) {
  LightBounds out;
  out.lower = out.upper = position;
  out.power = peak_power(intensity);
  return out;
}

LightBounds spot_light_bounds(Vec3f position, Vec3f axis, float cos_total, float intensity) {
  LightBounds out = point_light_bounds(position, intensity);
  out.axis = axis;
  // Represent the light by a cone of normals, which is just the axis up to a right angle, and a cone of emission of at
  // most a right angle. Intensity does not fall off with the angle, and the boundary is exact up to a right angle.
  const double angle = std::acos(std::clamp(double(cos_total), -1.0, 1.0)), right = 0.5 * double(kPi);
  out.cos_theta_o = static_cast<float>(std::cos(std::max(angle - right, 0.0)));
  out.cos_theta_e = static_cast<float>(std::cos(std::min(angle, right)));
  return out;
}

LightBounds frame_light_bounds(const LightFrameRow& frame, Vec3f position, double cos_total, double power) {
  const Vec3f rows[3] = {frame.row_x, frame.row_y, frame.row_z};
  const float size = dot(rows[2], rows[2]);
  float distortion = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j <= i; ++j)
      distortion = std::max(distortion, std::fabs(dot(rows[i], rows[j]) - (i == j ? size : 0)));
  if (distortion > 1e-4f * size) cos_total = -1.0;  // a distorted cone may reach in any direction
  const Vec3f axis = normalize(rows[2]);
  const double solid_angle = 2.0 * double(kPi) * std::max(1.0 - cos_total, 1e-6);
  return spot_light_bounds(position, axis, static_cast<float>(cos_total), static_cast<float>(power / solid_angle));
}

}  // namespace sheaf
