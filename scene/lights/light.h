// The interface of a kind of lights, for files and for the scene compiler. scene/lights/list.h lists the kinds;
// kernels/lights/light_kind.h states the interface of their kernels.
//
// A kind is a struct with
//     kLabel        names lights that have no name,
//     kDomain       where the light is,
//     Descriptions  the descriptions that may become lights of this kind, as LightDescriptions,
//     power         see light_power(); without the factor `integral`,
//     bounds        bounded lights: see bounds_of_light(),
// and optionally
//     integral, integral_key    the factor of its power that needs numerical integration; see LightCompiler,
//     position                  the point from which the light shines; see LightCompiler.
// A description is a struct with
//     kPlugins      its names in files that the dialects of Mitsuba and Nori write alike: an array, or kNoPlugins,
//     kParameters   with kPlugins only: the names of its parameters (scene/description/parameter_names.h), or
//     read(p)       reads them,
//     fields()      all parameters,
//     compile(where, context)  makes the row and the spectrum; returns nothing if the light is known to be black, and
//                              throws SceneError.
// Short functions are defined in the header, others in a .cpp file.
#pragma once

#include "scene/description/parameter_names.h"
#include "scene/lights/light_context.h"

#include <concepts>
#include <optional>
#include <string_view>
#include <vector>

namespace sheaf {

class Properties;
struct LightBounds;
struct LightDescription;
struct SceneView;

/// A plugin of the dialects of Mitsuba and Nori.
struct LightReader {
  std::string_view name;
  /// Reads the properties and sets LightDescription::model. The caller reports unused properties. Throws SceneError.
  void (*read)(Properties&, LightDescription&);
};

/// A description with all of its members.
template <class Description>
concept CompilableDescription = requires(const Description& light, const SourceLocation& where, LightContext& context) {
  Description::fields(light);
  { light.compile(where, context) } -> std::same_as<std::optional<CompiledLight>>;
}
&&(std::size(Description::kPlugins) > 0) == (DeclaresParameters<Description> || requires(Properties & p) {
  { Description::read(p) } -> std::same_as<Description>;
});

/// A list of descriptions of lights.
template <class... Description> struct LightDescriptions {};

/// Location of a kind of lights.
enum class LightDomain {
  kBounded,      ///< inside the scene
  kDistant,      ///< at infinity
  kEnvironment,  ///< at infinity, in all directions; at most one per scene
};

/// Sharing of the integral in a light's power.
enum class IntegralSharing {
  kNoIntegral,  ///< no integral: it is 1
  kShared,      ///< shared by all lights with the same kind, texture and key
  kOwn,         ///< not shared
};

/// Functions of a kind of lights for building light tables.
struct LightCompiler {
  using Power = Vec3f(const SceneView&, const LightRow&);
  using Bounds = LightBounds(const SceneView&, const LightRow&, double power);
  using Integral = Vec3f(const SceneView&, const LightRow&, int points);
  using IntegralKey = IntegralSharing(const SceneView&, const LightRow&, std::vector<std::uint32_t>& key);
  using Position = Vec3f(const LightRow&);

  const char* label;
  LightDomain domain;
  Power* power;
  Bounds* bounds = nullptr;  ///< null unless bounded
  /// The factor of light_power() that needs numerical integration with about `points` points; not included in `power`.
  /// Null if the kind has none.
  Integral* integral = nullptr;
  /// Appends data on which `integral` depends, besides kind and texture. Null if `integral` is null.
  IntegralKey* integral_key = nullptr;
  /// World space. Null for lights that do not shine from one point, and for those that shadow rays never reach.
  Position* position = nullptr;
};

namespace light_detail {

template <class Kind>
concept HasBounds = requires(LightCompiler::Bounds* bounds) {
  bounds = &Kind::bounds;
};
template <class Kind>
concept HasIntegral = requires(LightCompiler::Integral* integral) {
  integral = &Kind::integral;
};
template <class Kind>
concept HasIntegralKey = requires(LightCompiler::IntegralKey* key) {
  key = &Kind::integral_key;
};
template <class Kind>
concept HasPosition = requires(LightCompiler::Position* position) {
  position = &Kind::position;
};

}  // namespace light_detail

/// A struct with all members of a kind that are not optional.
template <class Kind>
concept CompilableLight = requires(LightCompiler::Power* power) {
  typename Kind::Descriptions;
  { Kind::kLabel } -> std::convertible_to<const char*>;
  { Kind::kDomain } -> std::convertible_to<LightDomain>;
  power = &Kind::power;
}
&&(Kind::kDomain == LightDomain::kBounded) == light_detail::HasBounds<Kind>&& light_detail::HasIntegral<Kind> ==
    light_detail::HasIntegralKey<Kind>;

template <CompilableLight Kind> constexpr LightCompiler make_light_compiler() {
  LightCompiler out{Kind::kLabel, Kind::kDomain, &Kind::power};
  if constexpr (light_detail::HasBounds<Kind>) out.bounds = &Kind::bounds;
  if constexpr (light_detail::HasIntegral<Kind>) out.integral = &Kind::integral, out.integral_key = &Kind::integral_key;
  if constexpr (light_detail::HasPosition<Kind>) out.position = &Kind::position;
  return out;
}

/// Area of the disk, m^2, through which light from infinity reaches the scene's bounding sphere.
float scene_disk_area(const SceneView& scene);

/// A row's radiance in R, G and B.
inline Vec3f emitted_rgb(const LightRow& light) { return {light.radiance.c0, light.radiance.c1, light.radiance.c2}; }

}  // namespace sheaf
