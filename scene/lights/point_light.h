// Isotropic point lights.
#pragma once

#include "core/math/vec3d.h"
#include "scene/lights/light.h"
#include "scene/lights/light_bounds.h"

namespace sheaf {

/// Data of a point light. LightRecord::radiance is its intensity, W / sr.
template <class L> struct PointLightData {
  Vec3<L> position;  ///< world space

  static constexpr auto fields(auto& s) { return std::tie(s.position); }
};

/// Emits `intensity` (W / sr) from `position` in all directions.
struct PointLightDescription {
  Vec3d position{0, 0, 0};
  SpectrumDescription intensity = SpectrumDescription::constant(1);

  static constexpr auto kPlugins = kNoPlugins;
  static constexpr auto fields(auto& s) { return std::tie(s.position, s.intensity); }

  std::optional<CompiledLight> compile(const SourceLocation& where, LightContext& context) const {
    return context.light(context.emission(intensity, where), PointLightData<Scalar>{position.rounded()});
  }
};

/// See scene/lights/light.h.
struct PointLightKind {
  static constexpr const char* kLabel = "point";
  static constexpr LightDomain kDomain = LightDomain::kBounded;
  using Descriptions = LightDescriptions<PointLightDescription>;

  static Vec3f power(const SceneView&, const LightRow& light) { return emitted_rgb(light) * (4 * kPi); }
  static LightBounds bounds(const SceneView&, const LightRow& light, double power) {
    return point_light_bounds(position(light), static_cast<float>(power * (0.25 * double(kInvPi))));
  }
  static Vec3f position(const LightRow& light) { return light.data<PointLightData>().position; }
};

}  // namespace sheaf
