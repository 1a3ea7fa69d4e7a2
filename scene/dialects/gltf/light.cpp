// Lights of KHR_lights_punctual, and cameras.
#include "scene/dialects/gltf/node_motion.h"
#include "scene/dialects/gltf/reader.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sheaf::gltf {

namespace {

/// Axis k of a matrix; not normalized.
Vec3f axis(const Matrix4& m, std::size_t k) {
  return {static_cast<float>(m.m[0][k]), static_cast<float>(m.m[1][k]), static_cast<float>(m.m[2][k])};
}

Vec3d position(const Matrix4& m) { return {m.m[0][3], m.m[1][3], m.m[2][3]}; }

/// A transform whose axes are orthonormal: position, -z and up of the matrix remain.
Transform rigid(const Matrix4& m, const GltfFile& file) {
  const Vec3f forward = -axis(m, 2), up = axis(m, 1);
  try {
    return Transform::translate(position(m)) * Transform::look_at({}, forward, up);
  } catch (const Error&) {
    throw SceneError({file.file.string(), 0}, "the transform of a camera or a light is singular");
  }
}

/// Whether the axes of a transform are orthonormal and right-handed.
bool is_rigid(const Transform& transform) {
  const Matrix4& m = transform.matrix();
  constexpr float kTolerance = 1e-5f;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j <= i; ++j)
      if (!(std::fabs(dot(axis(m, i), axis(m, j)) - (i == j ? 1.0f : 0.0f)) < kTolerance)) return false;
  return !transform.swaps_handedness();
}

/// rigid() over time.
Placement rigid(const NodePlacement& node, const GltfFile& file, const ShutterDescription& shutter) {
  if (node.motion == nullptr) return Placement(rigid(node.to_world, file));
  // Without scales, the motion keeps its keys
  bool stays_rigid = true;
  const AnimatedTransform tabulated = tabulate(shutter, [&](double time) {
    const Transform transform = node.motion->at(time);
    stays_rigid = stays_rigid && is_rigid(transform);
    return rigid(transform.matrix(), file);
  });
  return stays_rigid ? Placement(*node.motion) * Transform::scale({-1, 1, -1}) : Placement(tabulated);
}

}  // namespace

void add_light(const GltfLight& light, const NodePlacement& node, const GltfFile& file, Description& out) {
  const float intensity = static_cast<float>(std::max(light.intensity, 0.0));
  const SpectrumDescription emission{SpectrumDescription::Rgb{light.color * intensity}};
  LightDescription to;
  to.where = {file.file.string(), 0};
  if (light.kind == GltfLight::Kind::kPoint) {
    const Placement placement = node.motion != nullptr ? Placement(*node.motion) : Placement();
    const Vec3d at = node.motion != nullptr ? placement.to_world.translation() : position(node.to_world);
    to.model = PointLightDescription{at, emission};
    to.motion = add_motion(out.motions, placement);
  } else if (light.kind == GltfLight::Kind::kDirectional) {
    const Placement placement = node.motion != nullptr ? rigid(node, file, out.shutter) : Placement();
    const Vec3f direction = node.motion != nullptr ? placement.to_world.vector({0, 0, 1}) : -axis(node.to_world, 2);
    to.model = DirectionalLightDescription{direction, emission};
    to.motion = add_motion(out.motions, placement);
  } else {
    constexpr double kDegrees = 180 / std::numbers::pi;
    SpotLightDescription spot;
    spot.falloff = SpotLightDescription::Falloff::kSmooth;
    const Placement placement = rigid(node, file, out.shutter);
    spot.to_world = placement.to_world;
    to.motion = add_motion(out.motions, placement);
    spot.intensity = emission;
    spot.cutoff_angle = static_cast<float>(std::clamp(light.outer_angle * kDegrees, 1e-3, 90.0));
    spot.beam_width = static_cast<float>(std::clamp(light.inner_angle * kDegrees, 0.0, double(spot.cutoff_angle)));
    to.model = std::move(spot);
  }
  out.lights.push_back(std::move(to));
}

void set_camera(const GltfCamera& camera, const NodePlacement& node, const GltfFile& file, Description& out) {
  constexpr double kHeight = 600, kLargestAspect = 16;
  const double aspect = camera.perspective ? camera.aspect : std::abs(camera.xmag / camera.ymag);
  if (aspect > 0)
    out.film.width = static_cast<int>(std::lround(kHeight * std::clamp(aspect, 1 / kLargestAspect, kLargestAspect)));
  out.film.height = static_cast<int>(kHeight);
  CameraDescription& to = out.camera;
  to.where = {file.file.string(), 0};
  Placement placement = rigid(node, file, out.shutter);
  to.near_clip = static_cast<float>(camera.near_clip);
  to.far_clip = static_cast<float>(camera.far_clip);
  if (camera.perspective) {
    to.fov_axis = CameraDescription::FovAxis::kY;
    to.fov = static_cast<float>(camera.yfov * 180 / std::numbers::pi);
  } else {
    to.projection = CameraDescription::Projection::kOrthographic;
    const auto half_width = static_cast<float>(std::abs(camera.xmag));
    placement = placement * Transform::scale({half_width, half_width, 1});
  }
  const double lens_scale = camera.perspective ? 1 : std::abs(camera.xmag);
  to.aperture_radius = static_cast<float>(camera.aperture_radius / lens_scale);
  to.focus_distance = static_cast<float>(camera.focus_distance);
  to.principal_point_x = static_cast<float>(camera.principal_point_offset_x);
  to.principal_point_y = static_cast<float>(camera.principal_point_offset_y);
  to.to_world = placement.to_world;
  to.motion = add_motion(out.motions, placement);
}

}  // namespace sheaf::gltf
