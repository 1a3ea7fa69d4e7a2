// Lights of KHR_lights_punctual, and cameras.
#include "scene/dialects/gltf/reader.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sheaf::gltf {

namespace {

/// Axis k of a matrix; not normalised.
Vec3f axis(const Matrix4& m, std::size_t k) {
  return {static_cast<float>(m.m[0][k]), static_cast<float>(m.m[1][k]), static_cast<float>(m.m[2][k])};
}

/// A transform whose axes are orthonormal: position, -z and up of the matrix remain.
Transform rigid(const Matrix4& m, const GltfFile& file) {
  const Vec3f origin = axis(m, 3), forward = -axis(m, 2), up = axis(m, 1);
  try {
    return Transform::look_at(origin, origin + forward, up);
  } catch (const Error&) {
    throw SceneError({file.file.string(), 0}, "the transform of a camera or a light is singular");
  }
}

}  // namespace

void add_light(const GltfLight& light, const Matrix4& to_world, const GltfFile& file, Description& out) {
  const float intensity = static_cast<float>(std::max(light.intensity, 0.0));
  const SpectrumDescription emission{SpectrumDescription::Rgb{light.color * intensity}};
  LightDescription to;
  to.where = {file.file.string(), 0};
  if (light.kind == GltfLight::Kind::kPoint) {
    to.model = PointLightDescription{axis(to_world, 3), emission};
  } else if (light.kind == GltfLight::Kind::kDirectional) {
    to.model = DirectionalLightDescription{-axis(to_world, 2), emission};
  } else {
    constexpr double kDegrees = 180 / std::numbers::pi;
    SpotLightDescription spot;
    spot.falloff = SpotLightDescription::Falloff::kSmooth;
    spot.to_world = rigid(to_world, file);
    spot.intensity = emission;
    spot.cutoff_angle = static_cast<float>(std::clamp(light.outer_angle * kDegrees, 1e-3, 90.0));
    spot.beam_width = static_cast<float>(std::clamp(light.inner_angle * kDegrees, 0.0, double(spot.cutoff_angle)));
    to.model = std::move(spot);
  }
  out.lights.push_back(std::move(to));
}

void set_camera(const GltfCamera& camera, const Matrix4& to_world, const GltfFile& file, Description& out) {
  constexpr double kHeight = 600, kLargestAspect = 16;
  const double aspect = camera.perspective ? camera.aspect : std::abs(camera.xmag / camera.ymag);
  if (aspect > 0)
    out.film.width = static_cast<int>(std::lround(kHeight * std::clamp(aspect, 1 / kLargestAspect, kLargestAspect)));
  out.film.height = static_cast<int>(kHeight);
  CameraDescription& to = out.camera;
  to.where = {file.file.string(), 0};
  to.to_world = rigid(to_world, file);
  to.near_clip = static_cast<float>(camera.near_clip);
  to.far_clip = static_cast<float>(camera.far_clip);
  if (camera.perspective) {
    to.fov_axis = CameraDescription::FovAxis::kY;
    to.fov = static_cast<float>(camera.yfov * 180 / std::numbers::pi);
  } else {
    to.projection = CameraDescription::Projection::kOrthographic;
    const auto half_width = static_cast<float>(std::abs(camera.xmag));
    to.to_world = to.to_world * Transform::scale({half_width, half_width, 1});
  }
}

}  // namespace sheaf::gltf
