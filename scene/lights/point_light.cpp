#include "scene/lights/point_light.h"

#include "scene/lights/light_bounds.h"
#include "scene/lights/light_context.h"

namespace sheaf {

Vec3f PointLightKind::power(const SceneView&, const LightRow& light) { return emitted_rgb(light) * (4 * kPi); }

LightBounds PointLightKind::bounds(const SceneView&, const LightRow& light, double power) {
  return point_light_bounds(position(light), static_cast<float>(power * (0.25 * double(kInvPi))));
}

Vec3f PointLightKind::position(const LightRow& light) { return light.data<PointLightData>().position; }

std::optional<CompiledLight> place_light(const PointLightDescription& light, const SourceLocation& where,
                                         LightContext& context) {
  const PointLightData<Scalar> data{light.position};
  const LightEmission emission = context.emission(light.intensity, where);
  return CompiledLight{make_light_row(kLightKind<PointLightKind>, emission.rgb, data), emission.spectrum};
}

}  // namespace sheaf
