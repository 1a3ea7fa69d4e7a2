// Compiled lights: the interface between the compiler and the kinds of lights in scene/compile/lights/.
//
// Each LightKind must define light_compiler(), and each light description place_light(). The templates here declare
// them for all types; a missing definition is a link error.
#pragma once

#include "scene/compile/light_bounds.h"
#include "scene/spectra/spectrum_set.h"
#include "scene/tables/scene.h"

#include <concepts>
#include <span>

namespace sheaf {

/// A light that is not on a shape, with its frame if the kind has one.
struct CompiledLight {
  LightRow row;
  std::optional<LightFrameRow> frame;
  SpectrumRow spectrum = {};  ///< spectrum of LightRecord::radiance, in spectral mode
};

/// Scene data for placing lights.
struct LightContext {
  const Description& description;
  std::span<const TextureRow> textures;
  SpectrumSet* spectra;  ///< null in RGB mode
  Envmap& envmap;        ///< environment map of the scene, filled by its light
  std::vector<std::string>& warnings;

  /// Spectrum of emission, in spectral mode. Textures are relative to D65. Throws SceneError at `where`.
  SpectrumRow emission_row(const SpectrumInput& emission, const SourceLocation& where) const;
  /// Row of a texture. Throws SceneError at `where` if it does not exist or cannot be used by lights.
  std::uint32_t texture_row(TextureId id, const SourceLocation& where) const;
};

/// Makes a row without frame, texture and spectrum.
LightRow make_light_row(LightKind kind, Vec3f radiance, Vec3f position);

/// A row's radiance in R, G and B.
inline Vec3f emitted_rgb(const LightRow& light) { return {light.radiance.c0, light.radiance.c1, light.radiance.c2}; }

/// Location of a kind of lights.
enum class LightDomain {
  kBounded,      ///< inside the scene
  kDistant,      ///< at infinity
  kEnvironment,  ///< at infinity, in all directions; at most one per scene
};

/// Sharing of the integral in a light's power.
enum class IntegralSharing {
  kOne,   ///< no integral: it is 1
  kAll,   ///< shared by all lights with the same kind, texture and key
  kNone,  ///< not shared
};

/// Functions of a kind of lights for building light tables.
struct LightCompiler {
  LightDomain domain;
  /// See light_power(); without the factor `integral`.
  Vec3f (*power)(const SceneView&, const LightRow&);
  /// See bounds_of_light(). Null unless bounded.
  LightBounds (*bounds)(const SceneView&, const LightRow&, double power);
  /// The factor of light_power() that needs numerical integration with about `points` points; not included in `power`.
  /// Null if the kind has none.
  Vec3f (*integral)(const SceneView&, const LightRow&, int points) = nullptr;
  /// Appends data on which `integral` depends, besides kind and texture. Null if `integral` is null.
  IntegralSharing (*integral_key)(const SceneView&, const LightRow&, std::vector<std::uint32_t>& key) = nullptr;
};

/// A struct with the domain, the power and, if bounded, the bounds of a kind.
template <class Kind>
concept CompilableLight = requires(const SceneView& scene, const LightRow& light) {
  { Kind::kDomain } -> std::convertible_to<LightDomain>;
  { Kind::power(scene, light) } -> std::same_as<Vec3f>;
}
&&(Kind::kDomain == LightDomain::kBounded) == requires(const SceneView& scene, const LightRow& light) {
  { Kind::bounds(scene, light, 1.0) } -> std::same_as<LightBounds>;
};

template <CompilableLight Kind> LightCompiler make_light_compiler() {
  if constexpr (requires { &Kind::integral; })
    return {Kind::kDomain, &Kind::power, &Kind::bounds, &Kind::integral, &Kind::integral_key};
  else if constexpr (Kind::kDomain == LightDomain::kBounded)
    return {Kind::kDomain, &Kind::power, &Kind::bounds};
  else
    return {Kind::kDomain, &Kind::power, nullptr};
}

#pragma GCC diagnostic push
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored \
    "-Wnon-template-friend"  // intended: one function for every type, each defined in its own file
#endif

/// A light kind as a type.
template <LightKind Kind> struct LightTag { friend LightCompiler light_compiler(LightTag); };

/// A light of a description.
template <class Description> struct LightToPlace {
  const Description& light;
  const SourceLocation& where;
  LightContext& context;
  /// Compiles the light; empty if it is known to be black. Throws SceneError.
  friend std::optional<CompiledLight> place_light(const LightToPlace&);
};

#pragma GCC diagnostic pop

/// Functions of a row's kind.
const LightCompiler& light_compiler_of(const LightRow& light);

/// Whether a light is at infinity: environments, directional lights and suns.
bool is_infinite(const LightRow& light);

/// Power of a light, W in R, G and B. For lights at infinity, the power that reaches the scene's bounding sphere.
/// Textures are averaged over a few thousand points.
Vec3f light_power(const SceneView& scene, std::uint32_t light);

/// light_power() of all lights. Lights of the same shape share integrals. With hundreds of integrals, each uses fewer
/// points, but at least 256.
std::vector<Vec3f> light_powers(const SceneView& scene);

}  // namespace sheaf
