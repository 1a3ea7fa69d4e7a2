// Environment maps, and the sky as one.
#pragma once

#include "core/math/transform.h"
#include "scene/lights/constant_light.h"

#include <filesystem>

namespace sheaf {

/// Radiance (W / (m^2 sr)) from all directions outside the scene, from an image by longitude and latitude. The first
/// row is +y; columns run from -z over +x, +z and -x in the light's space.
struct EnvmapDescription {
  std::filesystem::path file;  ///< resolved path
  float scale = 1;
  Transform to_world;             ///< rotation, possibly mirrored; translation and uniform scale are ignored
  bool mis_compensation = false;  ///< sample only radiance above the mean (Karlik et al. 2019)
  bool raw = false;               ///< integers in the file are linear, not sRGB
  /// kOctahedral: a square equal-area image (Clarberg 2008), as in pbrt-v4, with +z in the middle.
  enum class Layout { kLatLong, kOctahedral } layout = Layout::kLatLong;

  static constexpr std::array kPlugins = {"envmap"};
  /// Reads `filename`, `scale` (default 1), `to_world`, `mis_compensation` (default true) and `gamma` of Mitsuba 0.6.
  /// Ignores its `cache`.
  static EnvmapDescription read(Properties& p);
  static constexpr auto fields(auto& s) {
    return std::tie(s.file, s.scale, s.to_world, s.mis_compensation, s.raw, s.layout);
  }
  std::optional<CompiledLight> compile(const SourceLocation& where, LightContext& context) const;
};

/// The sky model of Hosek and Wilkie 2012, for directions above the horizon.
struct SkyDescription {
  Vec3f up{0, 1, 0};  ///< towards the zenith, unit length
  /// Towards the sun, unit length. The skies of several suns are averaged; black below the horizon.
  std::vector<Vec3f> suns;
  float turbidity = 3;                                               ///< in [1, 10]
  SpectrumDescription albedo = SpectrumDescription::constant(0.3f);  ///< albedo of the ground
  float scale = 1;
  /// Scale of the suns rendered into the map, for suns that move across the sky. See SunDescription.
  float sun_scale = 0;
  float stretch = 1;     ///< in [1, 2]: 2 spreads the sky over the whole sphere
  bool extend = false;   ///< directions below the horizon repeat the horizon
  int resolution = 512;  ///< width of the generated map; its height is half of that

  static constexpr auto kPlugins = kNoPlugins;
  static constexpr auto fields(auto& s) {
    return std::tie(s.up, s.suns, s.turbidity, s.albedo, s.scale, s.sun_scale, s.stretch, s.extend, s.resolution);
  }
  std::optional<CompiledLight> compile(const SourceLocation& where, LightContext& context) const;
};

/// See scene/lights/light.h. LightRecord::radiance is the mean over all directions.
struct EnvmapLightKind : ConstantLightKind {
  using Descriptions = LightDescriptions<EnvmapDescription, SkyDescription>;
};

}  // namespace sheaf
