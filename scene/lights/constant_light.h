// Constant radiance from all directions.
#pragma once

#include "scene/lights/light.h"

namespace sheaf {

/// Constant radiance (W / (m^2 sr)) from all directions outside the scene.
struct ConstantLightDescription {
  SpectrumDescription radiance = SpectrumDescription::constant(1);

  static constexpr std::array kPlugins = {"constant"};
  static ConstantLightDescription read(auto& p) {
    return {p.spectrum("radiance", SpectrumDescription::constant(1), SpectrumRole::kEmission)};
  }
  static constexpr auto fields(auto& s) { return std::tie(s.radiance); }
};

/// See scene/lights/light.h.
struct ConstantLightKind {
  static constexpr const char* kLabel = "environment";
  static constexpr LightDomain kDomain = LightDomain::kEnvironment;
  using Descriptions = LightDescriptions<ConstantLightDescription>;

  static Vec3f power(const auto& scene, const LightRow& light) {
    const float disk = kPi * scene.radius * scene.radius;
    return emitted_rgb(light) * (4 * kPi * disk);
  }
};

/// See PlaceableLight.
std::optional<CompiledLight> place_light(const ConstantLightDescription& light, const SourceLocation& where,
                                         auto& context) {
  return context.template light<ConstantLightKind>(context.emission(light.radiance, where));
}

}  // namespace sheaf
