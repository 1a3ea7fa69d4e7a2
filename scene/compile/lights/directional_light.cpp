// Directional lights: row and power.
#include "scene/lights/directional_light.h"
#include "scene/compile/compile_materials.h"
#include "scene/compile/light.h"

#include <cmath>

namespace sheaf {

namespace {

struct DirectionalRows {
  static constexpr LightDomain kDomain = LightDomain::kDistant;

  static Vec3f power(const SceneView& scene, const LightRow& light) {
    const float disk = kPi * scene.radius * scene.radius;
    return emitted_rgb(light) * disk;
  }
};

}  // namespace

LightCompiler light_compiler(LightTag<LightKind::kDirectional>) { return make_light_compiler<DirectionalRows>(); }

std::optional<CompiledLight> place_light(const LightToPlace<DirectionalLightDescription>& l) {
  const float length = sheaf::length(l.light.direction);
  if (!(length > 0.0f) || !std::isfinite(length)) throw SceneError(l.where, "the direction of the light has no length");
  const DirectionalLightData<Scalar> data{l.light.direction * (-1.0f / length)};
  return CompiledLight{make_light_row(LightKind::kDirectional, emission_rgb(l.light.irradiance), data),
                       l.context.emission_row(l.light.irradiance, l.where)};
}

}  // namespace sheaf
