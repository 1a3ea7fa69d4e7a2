// Lights of a scene that are not on shapes.
#pragma once

#include "core/error.h"
#include "core/transform.h"
#include "scene/description/camera.h"
#include "scene/description/inputs.h"

#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace sheaf {

/// Emits `intensity` (W / sr) from `position` in all directions.
struct PointLightDescription {
  Vec3f position{0, 0, 0};
  SpectrumDescription intensity = SpectrumDescription::constant(1);
};
/// Constant radiance (W / (m^2 sr)) from all directions outside the scene.
struct ConstantLightDescription {
  SpectrumDescription radiance = SpectrumDescription::constant(1);
};

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
};

/// Emits from the origin of its space: `intensity` (W / sr) times a square image of all directions, in the equal-area
/// octahedral layout of EnvmapDescription::Layout::kOctahedral.
struct GoniometricLightDescription {
  Transform to_world;  ///< a rotation, possibly with a reflection, and a translation
  SpectrumDescription intensity = SpectrumDescription::constant(1);
  TextureId picture{};
};

/// Parallel light from infinitely far away: `irradiance` (W / m^2) on a surface perpendicular to it.
struct DirectionalLightDescription {
  Vec3f direction{0, 0, 1};  ///< direction in which the light travels; any length except zero
  SpectrumDescription irradiance = SpectrumDescription::constant(1);
};

/// A pinhole camera in reverse. Emits pi * scale * irradiance / cos^3 (W / sr), with the cosine of the angle to its +z.
/// The image fills the field of view and is upright when looking along +z.
struct ProjectorDescription {
  Transform to_world;  ///< as for a camera; must not distort
  SpectrumInput irradiance = SpectrumDescription::constant(1);
  float scale = 1;
  /// The intensity is scale * irradiance (W / sr) instead, without the factor pi / cos^3.
  bool is_even = false;
  float fov = 50;  ///< degrees
  CameraDescription::FovAxis fov_axis = CameraDescription::FovAxis::kX;
};

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
};

/// The sun of Hosek and Wilkie 2013: a disk of uniform radiance, the mean over the model's disk.
struct SunDescription {
  Vec3f up{0, 1, 0}, direction{0, 1, 0};  ///< towards the zenith and towards the sun, unit length
  float turbidity = 3;                    ///< in [1, 10]
  float scale = 1;
  /// Half the angular diameter of the sun, degrees, in [0, 90). It does not affect the irradiance.
  float radius = kSunRadius;
  float stretch = 1;  ///< see SkyDescription::stretch

  static constexpr float kSunRadius = 0.2679f;
};

/// A beam of light along a ray: `power` (W) from the origin of its space along +z. Only photons can sample it.
struct BeamDescription {
  Transform to_world;
  SpectrumDescription power = SpectrumDescription::constant(1);
};

struct LightDescription {
  std::variant<PointLightDescription, ConstantLightDescription, SpotLightDescription, GoniometricLightDescription,
               DirectionalLightDescription, ProjectorDescription, EnvmapDescription, SkyDescription, SunDescription,
               BeamDescription>
      model;
  SourceLocation where;
  std::string id = {};  ///< name in files; may be empty
};

}  // namespace sheaf
