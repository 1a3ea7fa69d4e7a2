// Spot lights with linear or smooth falloff.
#pragma once

#include "core/math/transform.h"
#include "scene/lights/light.h"

namespace sheaf {

/// Spot light at the origin of its space, around +z: `intensity` (W / sr) within `beam_width`, zero beyond
/// `cutoff_angle`.
struct SpotLightDescription {
  /// Falloff in between: linear in the angle (Mitsuba), or a smooth step in its cosine (pbrt).
  enum class Falloff { kLinear, kSmooth } falloff = Falloff::kLinear;
  Transform to_world;
  SpectrumDescription intensity = SpectrumDescription::constant(1);
  float cutoff_angle = 20, beam_width = 15;  ///< degrees from the axis, in (0, 180] and [0, cutoff_angle]
  /// Multiplies the intensity; the cone fills the unit square of uv. Only for kLinear with a cutoff_angle below 90
  /// degrees.
  std::optional<TextureId> texture;

  static constexpr auto kPlugins = kNoLightPlugins;
  static constexpr auto fields(auto& s) {
    return std::tie(s.falloff, s.to_world, s.intensity, s.cutoff_angle, s.beam_width, s.texture);
  }
};

/// See PlaceableLight.
std::optional<CompiledLight> place_light(const SpotLightDescription& light, const SourceLocation& where,
                                         LightContext& context);

/// Data of a spot light whose intensity falls off linearly in the angle. LightRecord::radiance is the intensity on its
/// axis, W / sr.
template <class L> struct LinearSpotLightData {
  Vec3<L> position;                 ///< world space
  typename L::Uint frame;           ///< into LightView::frames
  typename L::Float cutoff_angle;   ///< from the axis, radians
  typename L::Float inverse_width;  ///< 1 / (cutoff angle - beam width)
  typename L::Float cot_cutoff;     ///< with a texture: 1 / tan(cutoff angle)

  static constexpr auto kPlugins = kNoLightPlugins;
  static constexpr auto fields(auto& s) {
    return std::tie(s.position, s.frame, s.cutoff_angle, s.inverse_width, s.cot_cutoff);
  }
};

/// Data of a spot light whose intensity falls off as a smooth step in the cosine of the angle. LightRecord::radiance is
/// the intensity on its axis, W / sr.
template <class L> struct SmoothSpotLightData {
  Vec3<L> position;                 ///< world space
  typename L::Uint frame;           ///< into LightView::frames
  typename L::Float cos_cutoff;     ///< cosine of the cutoff angle
  typename L::Float inverse_width;  ///< 1 / (cosine of the beam width - cos_cutoff)
  typename L::Float cot_cutoff;     ///< with a texture: 1 / tan(cutoff angle)

  static constexpr auto kPlugins = kNoLightPlugins;
  static constexpr auto fields(auto& s) {
    return std::tie(s.position, s.frame, s.cos_cutoff, s.inverse_width, s.cot_cutoff);
  }
};

/// See scene/lights/light.h.
struct LinearSpotLightKind {
  static constexpr const char* kLabel = "spot";
  static constexpr LightDomain kDomain = LightDomain::kBounded;
  using Descriptions = LightDescriptions<SpotLightDescription>;

  static Vec3f power(const SceneView& scene, const LightRow& light);
  static LightBounds bounds(const SceneView& scene, const LightRow& light, double power);
  static Vec3f integral(const SceneView& scene, const LightRow& light, int points);
  static IntegralSharing integral_key(const SceneView& scene, const LightRow& light, std::vector<std::uint32_t>& key);
  static Vec3f position(const LightRow& light);
};

/// See scene/lights/light.h.
struct SmoothSpotLightKind {
  static constexpr const char* kLabel = "spot";
  static constexpr LightDomain kDomain = LightDomain::kBounded;
  using Descriptions = LightDescriptions<>;

  static Vec3f power(const SceneView& scene, const LightRow& light);
  static LightBounds bounds(const SceneView& scene, const LightRow& light, double power);
  static Vec3f integral(const SceneView& scene, const LightRow& light, int points);
  static IntegralSharing integral_key(const SceneView& scene, const LightRow& light, std::vector<std::uint32_t>& key);
  static Vec3f position(const LightRow& light);
};

}  // namespace sheaf
