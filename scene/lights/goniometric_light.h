// Point lights with an image of all directions.
#pragma once

#include "scene/lights/framed_light.h"

namespace sheaf {

/// Emits from the origin of its space: `intensity` (W / sr) times a square image of all directions, in the equal-area
/// octahedral layout of EnvmapDescription::Layout::kOctahedral.
struct GoniometricLightDescription {
  Transform to_world;  ///< a rotation, possibly with a reflection, and a translation
  SpectrumDescription intensity = SpectrumDescription::constant(1);
  TextureId image{};

  static constexpr auto kPlugins = kNoPlugins;
  static constexpr auto fields(auto& s) { return std::tie(s.to_world, s.intensity, s.image); }
  std::optional<CompiledLight> compile(const SourceLocation& where, LightContext& context) const;
};

/// See scene/lights/light.h. The data are FramedLightData. LightRecord::radiance is the intensity where the image is 1,
/// W / sr.
struct GoniometricLightKind : FramedLightKind {
  static constexpr const char* kLabel = "goniometric";
  using Descriptions = LightDescriptions<GoniometricLightDescription>;

  static Vec3f power(const SceneView& scene, const LightRow& light);
  static LightBounds bounds(const SceneView& scene, const LightRow& light, double power);
  static Vec3f integral(const SceneView& scene, const LightRow& light, int points);
  static IntegralSharing integral_key(const SceneView& scene, const LightRow& light, std::vector<std::uint32_t>& key);
};

}  // namespace sheaf
