// Beams of light along a ray.
#pragma once

#include "core/math/transform.h"
#include "scene/lights/light.h"

namespace sheaf {

/// A beam of light along a ray: `power` (W) from the origin of its space along +z. Only photons can sample it.
struct BeamDescription {
  Transform to_world;
  SpectrumDescription power = SpectrumDescription::constant(1);

  static constexpr auto kPlugins = kNoPlugins;
  static constexpr auto fields(auto& s) { return std::tie(s.to_world, s.power); }
  std::optional<CompiledLight> compile(const SourceLocation& where, LightContext& context) const;
};

/// Data of a beam. LightRecord::radiance is its power, W.
template <class L> struct BeamLightData {
  Vec3<L> position;   ///< where the beam starts, world space
  Vec3<L> direction;  ///< of travel, unit length

  static constexpr auto fields(auto& s) { return std::tie(s.position, s.direction); }
};

/// See scene/lights/light.h.
struct BeamLightKind {
  static constexpr const char* kLabel = "collimated";
  static constexpr LightDomain kDomain = LightDomain::kBounded;
  using Descriptions = LightDescriptions<BeamDescription>;

  static Vec3f power(const SceneView& scene, const LightRow& light);
  static LightBounds bounds(const SceneView& scene, const LightRow& light, double power);
};

}  // namespace sheaf
