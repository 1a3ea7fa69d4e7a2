// The list of all kinds of lights. From it derive LightKind, LightDescription::model, the names in files with their
// readers, the table of functions for the scene compiler, and the list of kernels in kernels/lights/list.h.
#pragma once

#include "scene/description/motion.h"
#include "scene/lights/beam_light.h"
#include "scene/lights/constant_light.h"
#include "scene/lights/directional_light.h"
#include "scene/lights/envmap_light.h"
#include "scene/lights/goniometric_light.h"
#include "scene/lights/mesh_light.h"
#include "scene/lights/point_light.h"
#include "scene/lights/projector_light.h"
#include "scene/lights/quadric_light.h"
#include "scene/lights/rectangle_light.h"
#include "scene/lights/sphere_light.h"
#include "scene/lights/spot_light.h"
#include "scene/lights/sun_light.h"
#include "scene/lights/volume_light.h"

#include <algorithm>
#include <optional>
#include <string>
#include <type_traits>
#include <variant>

namespace sheaf {

namespace light_list_detail {

/// A variant of the descriptions in several LightDescriptions.
template <class... Lists> struct AnyDescription;
template <class... All> struct AnyDescription<LightDescriptions<All...>> {
  static_assert((CompilableDescription<All> && ...), "a description omits something; see scene/lights/light.h");
  using Type = std::variant<All...>;
};
template <class... Some, class... More, class... Lists>
struct AnyDescription<LightDescriptions<Some...>, LightDescriptions<More...>, Lists...>
    : AnyDescription<LightDescriptions<Some..., More...>, Lists...> {};

/// Whether a list contains a description.
template <class Description, class... All> constexpr bool lists(LightDescriptions<All...>) {
  return (std::is_same_v<Description, All> || ...);
}

}  // namespace light_list_detail

/// A list of kinds of lights.
template <CompilableLight... Kinds> struct LightKindList {
  static constexpr std::size_t kCount = sizeof...(Kinds);
  /// Any description of a light.
  using Model = typename light_list_detail::AnyDescription<typename Kinds::Descriptions...>::Type;

  /// The position of a kind.
  template <class Kind> static constexpr LightKind kind_of() {
    static_assert((std::is_same_v<Kind, Kinds> + ...) == 1, "a kind must be listed once");
    constexpr bool kMatches[] = {std::is_same_v<Kind, Kinds>...};
    return static_cast<LightKind>(std::find(kMatches, kMatches + kCount, true) - kMatches);
  }
  /// The first kind that lists a description.
  template <class Description> static constexpr LightKind kind_for() {
    constexpr bool kMatches[] = {light_list_detail::lists<Description>(typename Kinds::Descriptions{})...};
    return static_cast<LightKind>(std::find(kMatches, kMatches + kCount, true) - kMatches);
  }
  /// Calls f.operator()<Kind>() for each kind.
  template <class F> static constexpr void for_each(F&& f) { (f.template operator()<Kinds>(), ...); }
  /// Whether a description is that of an environment.
  static bool is_environment(const Model& model) {
    return std::visit(
        []<class Description>(const Description&) {
          return ((Kinds::kDomain == LightDomain::kEnvironment &&
                   light_list_detail::lists<Description>(typename Kinds::Descriptions{})) ||
                  ...);
        },
        model);
  }
};

/// All kinds of lights, in the order of LightKind.
using LightKinds = LightKindList<MeshLightKind,         //
                                 RectangleLightKind,    //
                                 SphereLightKind,       //
                                 QuadricLightKind,      //
                                 PointLightKind,        //
                                 LinearSpotLightKind,   //
                                 SmoothSpotLightKind,   //
                                 GoniometricLightKind,  //
                                 ProjectorLightKind,    //
                                 BeamLightKind,         //
                                 DirectionalLightKind,  //
                                 SunLightKind,          //
                                 ConstantLightKind,     //
                                 EnvmapLightKind,       //
                                 VolumeLightKind>;

/// The LightKind of a kind, such as kLightKind<MeshLightKind>.
template <class Kind> inline constexpr LightKind kLightKind = LightKinds::kind_of<Kind>();

/// A light of a scene that is not on a shape.
struct LightDescription {
  LightKinds::Model model;
  SourceLocation where;
  std::string id = {};  ///< name in files; may be empty
  std::optional<MotionId> motion = {};
};

/// Compiles a light. Returns nothing if it is known to be black. Throws SceneError.
std::optional<CompiledLight> compile_light(const LightDescription& light, LightContext& context);

/// The functions of each kind, by LightKind.
std::span<const LightCompiler> light_compilers();
/// The functions of a row's kind.
const LightCompiler& light_compiler_of(const LightRow& light);

/// The lights that the dialects of Mitsuba and Nori write alike.
std::span<const LightReader> light_readers();

/// Whether a light is at infinity: environments, directional lights and suns.
bool is_infinite(const LightRow& light);

}  // namespace sheaf
