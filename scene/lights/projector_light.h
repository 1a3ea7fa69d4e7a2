// Projectors.
#pragma once

#include "scene/description/camera.h"
#include "scene/lights/framed_light.h"

namespace sheaf {

/// A pinhole camera in reverse. Emits pi * scale * irradiance / cos^3 (W / sr), with the cosine of the angle to its +z.
/// The image fills the field of view and is upright when looking along +z.
struct ProjectorDescription {
  Transform to_world;  ///< as for a camera; must not distort
  SpectrumInput irradiance = SpectrumDescription::constant(1);
  float scale = 1;
  /// The intensity is scale * irradiance (W / sr) instead, without the factor pi / cos^3.
  bool constant_intensity = false;
  float fov = 50;  ///< degrees
  CameraDescription::FovAxis fov_axis = CameraDescription::FovAxis::kX;

  static constexpr auto kPlugins = kNoPlugins;
  static constexpr auto fields(auto& s) {
    return std::tie(s.to_world, s.irradiance, s.scale, s.constant_intensity, s.fov, s.fov_axis);
  }
  std::optional<CompiledLight> compile(const SourceLocation& where, LightContext& context) const;
};

/// Data of a projector. LightRecord::radiance is the intensity (W / sr) on its axis where the image is 1.
template <class L> struct ProjectorLightData : FramedLightData<L> {
  Vec2<L> image_scale;  ///< reciprocals of the image's width and height at z = 1

  static constexpr auto fields(auto& s) { return std::tie(s.position, s.frame, s.image_scale); }
};

/// See scene/lights/light.h.
struct ProjectorLightKind : FramedLightKind {
  static constexpr const char* kLabel = "projector";
  using Descriptions = LightDescriptions<ProjectorDescription>;

  static LightBounds bounds(const SceneView& scene, const LightRow& light, double power);
  static Vec3f integral(const SceneView& scene, const LightRow& light, int points);
  static IntegralSharing integral_key(const SceneView& scene, const LightRow& light, std::vector<std::uint32_t>& key);
};

}  // namespace sheaf
