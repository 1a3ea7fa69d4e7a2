// Lights as rows of tables: what the files of single kinds, scene/compile/lights/, are given and what they must define.
//
// Of every LightKind such a file defines light_compiler(), and of every description of a light place_light(). Both are
// declared here for all of them at once; the program doesn't link where one is missing.
#pragma once

#include "scene/compile/light_bounds.h"
#include "scene/compile/spectra.h"
#include "scene/tables/scene.h"

#include <concepts>
#include <span>

namespace sheaf {

/// A light that is not on a shape, with its frame if the kind has one.
struct CompiledLight {
  LightRow row;
  std::optional<LightFrameRow> frame;
  SpectrumRow spectrum = {};  ///< what LightRecord::radiance is, in spectral mode
};

/// What lights are placed in.
struct LightContext {
  const Description& description;
  std::span<const TextureRow> textures;
  SpectrumSet* spectra;  ///< null in RGB mode
  Envmap& envmap;        ///< of the scene; its light fills it
  std::vector<std::string>& warnings;

  /// The row of what a light emits, in spectral mode. Textures are relative to D65. Throws SceneError at `where`.
  SpectrumRow emission_row(const SpectrumInput& emission, const SourceLocation& where) const;
  /// Throws SceneError at `where` for a texture that there is not.
  std::uint32_t texture_row(TextureId id, const SourceLocation& where) const;
};

/// A row of a kind without frame, texture and spectrum.
LightRow make_light_row(LightKind kind, Vec3f radiance, Vec3f position);

/// A row's radiance in R, G and B.
inline Vec3f emitted_rgb(const LightRow& light) { return {light.radiance.c0, light.radiance.c1, light.radiance.c2}; }

/// Where a kind of light shines from.
enum class LightDomain {
  kBounded,      ///< somewhere inside of the scene
  kDistant,      ///< outside of it
  kEnvironment,  ///< outside of it, from all directions: there may be one
};

/// Who may use the integral in a light's power.
enum class IntegralSharing {
  kOne,   ///< nobody: it is 1
  kAll,   ///< all lights of the same kind, texture and key
  kNone,  ///< the light alone
};

/// A kind of light to who makes tables of lights.
struct LightCompiler {
  LightDomain domain;
  /// See light_power(); without `integral`.
  Vec3f (*power)(const SceneView&, const LightRow&);
  /// See bounds_of_light(). Null unless bounded.
  LightBounds (*bounds)(const SceneView&, const LightRow&, double power);
  /// A factor of light_power() that takes numerical integration, by about so many points, and is no part of `power`.
  /// Null where nothing does.
  Vec3f (*integral)(const SceneView&, const LightRow&, int points) = nullptr;
  /// Appends what `integral` depends on besides the kind and the texture. Null where `integral` is.
  IntegralSharing (*integral_key)(const SceneView&, const LightRow&, std::vector<std::uint32_t>& key) = nullptr;
};

/// A struct with the reach, the power and, if it is bounded, the bounds of a kind.
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
    "-Wnon-template-friend"  // meant: a function for every type, each defined in its own file
#endif

/// Names a kind as a type.
template <LightKind Kind> struct LightTag { friend LightCompiler light_compiler(LightTag); };

/// A light of a description.
template <class Description> struct LightToPlace {
  const Description& light;
  const SourceLocation& where;
  LightContext& context;
  /// Its row and its spectrum, or nothing if it is black for sure. Throws SceneError.
  friend std::optional<CompiledLight> place_light(const LightToPlace&);
};

#pragma GCC diagnostic pop

/// What is known of a row's kind.
const LightCompiler& light_compiler_of(const LightRow& light);

/// Whether a light shines from outside of the scene: environments and directions.
bool is_infinite(const LightRow& light);

/// The power that a light gives off, W in R, G and B. Of lights outside of the scene that which reaches the scene's
/// bounding sphere. Textures are averaged by a few thousand points.
Vec3f light_power(const SceneView& scene, std::uint32_t light);

/// The same of all lights. Those of the same shape share integrals, and where hundreds are left, each is of fewer
/// points, 256 at least.
std::vector<Vec3f> light_powers(const SceneView& scene);

}  // namespace sheaf
