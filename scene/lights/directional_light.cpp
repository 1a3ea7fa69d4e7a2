#include "scene/lights/directional_light.h"

#include <cmath>

namespace sheaf {

Vec3f DirectionalLightKind::power(const SceneView& scene, const LightRow& light) {
  return emitted_rgb(light) * scene_disk_area(scene);
}

std::optional<CompiledLight> DirectionalLightDescription::compile(const SourceLocation& where,
                                                                  LightContext& context) const {
  const float length = sheaf::length(direction);
  if (!(length > 0.0f) || !std::isfinite(length)) throw SceneError(where, "the direction of the light has no length");
  const DirectionalLightData<Scalar> data{direction * (-1.0f / length)};
  return context.light(context.emission(irradiance, where), data);
}

}  // namespace sheaf
