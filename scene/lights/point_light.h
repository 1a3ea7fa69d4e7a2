// Isotropic point lights.
#pragma once

#include "scene/lights/light.h"

namespace sheaf {

/// Emits `intensity` (W / sr) from `position` in all directions.
struct PointLightDescription {
  Vec3f position{0, 0, 0};
  SpectrumDescription intensity = SpectrumDescription::constant(1);
};

/// See PlaceableLight.
std::optional<CompiledLight> place_light(const PointLightDescription& light, const SourceLocation& where,
                                         LightContext& context);

/// Data of a point light. LightRecord::radiance is its intensity, W / sr.
template <class L> struct PointLightData {
  Vec3<L> position;  ///< world space

  static constexpr auto fields(auto& s) { return std::tie(s.position); }
};

/// See scene/lights/light.h.
struct PointLightKind {
  static constexpr const char* kLabel = "point";
  static constexpr LightDomain kDomain = LightDomain::kBounded;
  using Descriptions = LightDescriptions<PointLightDescription>;
  static constexpr std::array<LightReader, 0> kReaders = {};

  static Vec3f power(const SceneView& scene, const LightRow& light);
  static LightBounds bounds(const SceneView& scene, const LightRow& light, double power);
  static Vec3f position(const LightRow& light);
};

}  // namespace sheaf
