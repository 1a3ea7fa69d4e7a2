// Constant radiance from all directions.
#pragma once

#include "scene/lights/light.h"

namespace sheaf {

/// Constant radiance (W / (m^2 sr)) from all directions outside the scene.
struct ConstantLightDescription {
  SpectrumDescription radiance = SpectrumDescription::constant(1);
};

/// See PlaceableLight.
std::optional<CompiledLight> place_light(const ConstantLightDescription& light, const SourceLocation& where,
                                         LightContext& context);

/// See scene/lights/light.h.
struct ConstantLightKind {
  static constexpr const char* kLabel = "environment";
  static constexpr LightDomain kDomain = LightDomain::kEnvironment;
  using Descriptions = LightDescriptions<ConstantLightDescription>;
  /// Reads `radiance` (default 1).
  static void read(Properties& p, LightDescription& light);
  static constexpr std::array kReaders = {LightReader{"constant", &read}};

  static Vec3f power(const SceneView& scene, const LightRow& light);
};

}  // namespace sheaf
