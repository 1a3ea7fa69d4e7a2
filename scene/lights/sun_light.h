// Suns: disks infinitely far away. A sun of radius 0 becomes a directional light.
#pragma once

#include "scene/lights/directional_light.h"

namespace sheaf {

/// The sun of Hosek and Wilkie 2013: a disk of uniform radiance, the mean over the model's disk.
struct SunDescription {
  Vec3f up{0, 1, 0}, direction{0, 1, 0};  ///< towards the zenith and towards the sun, unit length
  float turbidity = 3;                    ///< in [1, 10]
  float scale = 1;
  /// Half the angular diameter of the sun, degrees, in [0, 90). It does not affect the irradiance.
  float radius = kSunRadius;
  float stretch = 1;  ///< see SkyDescription::stretch

  static constexpr float kSunRadius = 0.2679f;

  static constexpr auto kPlugins = kNoPlugins;
  static constexpr auto fields(auto& s) {
    return std::tie(s.up, s.direction, s.turbidity, s.scale, s.radius, s.stretch);
  }
  std::optional<CompiledLight> compile(const SourceLocation& where, LightContext& context) const;
};

/// Data of a sun.
template <class L> struct SunLightData {
  Vec3<L> to_light;                 ///< towards the center of the disk, unit length
  typename L::Float one_minus_cos;  ///< 1 - cosine of the angular radius

  static constexpr auto fields(auto& s) { return std::tie(s.to_light, s.one_minus_cos); }
};

/// See scene/lights/light.h.
struct SunLightKind {
  static constexpr const char* kLabel = "sun";
  static constexpr LightDomain kDomain = LightDomain::kDistant;
  using Descriptions = LightDescriptions<SunDescription>;

  static Vec3f power(const SceneView& scene, const LightRow& light);
};

}  // namespace sheaf
