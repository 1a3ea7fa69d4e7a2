// Point lights with an image of all directions.
#pragma once

#include "core/math/transform.h"
#include "scene/lights/light.h"

namespace sheaf {

/// Emits from the origin of its space: `intensity` (W / sr) times a square image of all directions, in the equal-area
/// octahedral layout of EnvmapDescription::Layout::kOctahedral.
struct GoniometricLightDescription {
  Transform to_world;  ///< a rotation, possibly with a reflection, and a translation
  SpectrumDescription intensity = SpectrumDescription::constant(1);
  TextureId image{};

  static constexpr auto kPlugins = kNoLightPlugins;
  static constexpr auto fields(auto& s) { return std::tie(s.to_world, s.intensity, s.image); }
};

/// See PlaceableLight.
std::optional<CompiledLight> place_light(const GoniometricLightDescription& light, const SourceLocation& where,
                                         LightContext& context);

/// Data of a goniometric light. LightRecord::radiance is its intensity where the image is 1, W / sr.
template <class L> struct GoniometricLightData {
  Vec3<L> position;        ///< world space
  typename L::Uint frame;  ///< into LightView::frames

  static constexpr auto kPlugins = kNoLightPlugins;
  static constexpr auto fields(auto& s) { return std::tie(s.position, s.frame); }
};

/// See scene/lights/light.h.
struct GoniometricLightKind {
  static constexpr const char* kLabel = "goniometric";
  static constexpr LightDomain kDomain = LightDomain::kBounded;
  using Descriptions = LightDescriptions<GoniometricLightDescription>;

  static Vec3f power(const SceneView& scene, const LightRow& light);
  static LightBounds bounds(const SceneView& scene, const LightRow& light, double power);
  static Vec3f integral(const SceneView& scene, const LightRow& light, int points);
  static IntegralSharing integral_key(const SceneView& scene, const LightRow& light, std::vector<std::uint32_t>& key);
  static Vec3f position(const LightRow& light);
};

}  // namespace sheaf
