#include "scene/lights/directional_light.h"

#include "scene/lights/light_context.h"
#include "scene/tables/scene_view.h"

#include <cmath>

namespace sheaf {

Vec3f DirectionalLightKind::power(const SceneView& scene, const LightRow& light) {
  const float disk = kPi * scene.radius * scene.radius;
  return emitted_rgb(light) * disk;
}

std::optional<CompiledLight> place_light(const DirectionalLightDescription& light, const SourceLocation& where,
                                         LightContext& context) {
  const float length = sheaf::length(light.direction);
  if (!(length > 0.0f) || !std::isfinite(length)) throw SceneError(where, "the direction of the light has no length");
  const DirectionalLightData<Scalar> data{light.direction * (-1.0f / length)};
  return context.light<DirectionalLightKind>(context.emission(light.irradiance, where), data);
}

}  // namespace sheaf
