// Constant radiance from all directions.
#pragma once

#include "scene/lights/light.h"

namespace sheaf {

/// Constant radiance (W / (m^2 sr)) from all directions outside the scene.
struct ConstantLightDescription {
  SpectrumDescription radiance = SpectrumDescription::constant(1);

  static constexpr std::array kPlugins = {"constant"};
  static constexpr ParameterName kParameters[] = {{"radiance"}};
  static constexpr auto fields(auto& s) { return std::tie(s.radiance); }

  std::optional<CompiledLight> compile(const SourceLocation& where, LightContext& context) const {
    return context.light(context.emission(radiance, where));
  }
};

/// See scene/lights/light.h.
struct ConstantLightKind {
  static constexpr const char* kLabel = "environment";
  static constexpr LightDomain kDomain = LightDomain::kEnvironment;
  using Descriptions = LightDescriptions<ConstantLightDescription>;

  static Vec3f power(const SceneView& scene, const LightRow& light) {
    return emitted_rgb(light) * (4 * kPi * scene_disk_area(scene));
  }
};

}  // namespace sheaf
