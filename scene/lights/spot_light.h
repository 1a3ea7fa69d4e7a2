// Spot lights with linear or smooth falloff.
#pragma once

#include "scene/lights/framed_light.h"

#include <type_traits>

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

  static constexpr auto kPlugins = kNoPlugins;
  static constexpr auto fields(auto& s) {
    return std::tie(s.falloff, s.to_world, s.intensity, s.cutoff_angle, s.beam_width, s.texture);
  }
  std::optional<CompiledLight> compile(const SourceLocation& where, LightContext& context) const;
};

/// Data of a spot light. LightRecord::radiance is the intensity on its axis, W / sr. Widths are angles from the axis in
/// radians if the intensity falls off linearly in the angle, and cosines of them if it falls off as a smooth step in
/// the cosine.
template <class L> struct SpotLightData : FramedLightData<L> {
  typename L::Float cutoff;         ///< width of the cone
  typename L::Float inverse_width;  ///< 1 / |width of the cone - width of the beam|
  typename L::Float cot_cutoff;     ///< with a texture: 1 / tan(cutoff angle)

  static constexpr auto fields(auto& s) {
    return std::tie(s.position, s.frame, s.cutoff, s.inverse_width, s.cot_cutoff);
  }
};

/// See scene/lights/light.h. Descriptions are compiled to the kind of their falloff.
template <bool kSmooth> struct SpotLightKind : FramedLightKind {
  static constexpr const char* kLabel = "spot";
  static constexpr bool kIsSmooth = kSmooth;
  using Descriptions = std::conditional_t<kSmooth, LightDescriptions<>, LightDescriptions<SpotLightDescription>>;

  static LightBounds bounds(const SceneView& scene, const LightRow& light, double power);
  static Vec3f integral(const SceneView& scene, const LightRow& light, int points);
  static IntegralSharing integral_key(const SceneView& scene, const LightRow& light, std::vector<std::uint32_t>& key);
};
using LinearSpotLightKind = SpotLightKind<false>;
using SmoothSpotLightKind = SpotLightKind<true>;

}  // namespace sheaf
