// Parallel light from infinitely far away.
#pragma once

#include "scene/lights/light.h"

namespace sheaf {

/// Parallel light from infinitely far away: `irradiance` (W / m^2) on a surface perpendicular to it.
struct DirectionalLightDescription {
  Vec3f direction{0, 0, 1};  ///< direction in which the light travels; any length except zero
  SpectrumDescription irradiance = SpectrumDescription::constant(1);

  static constexpr auto kPlugins = kNoPlugins;
  static constexpr auto fields(auto& s) { return std::tie(s.direction, s.irradiance); }
  std::optional<CompiledLight> compile(const SourceLocation& where, LightContext& context) const;
};

/// Data of a directional light. LightRecord::radiance is its irradiance on a perpendicular surface, W / m^2.
template <class L> struct DirectionalLightData {
  Vec3<L> to_light;  ///< unit length

  static constexpr auto fields(auto& s) { return std::tie(s.to_light); }
};

/// See scene/lights/light.h.
struct DirectionalLightKind {
  static constexpr const char* kLabel = "directional";
  static constexpr LightDomain kDomain = LightDomain::kDistant;
  using Descriptions = LightDescriptions<DirectionalLightDescription>;

  static Vec3f power(const SceneView& scene, const LightRow& light);
};

}  // namespace sheaf
