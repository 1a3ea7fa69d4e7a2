#include "scene/lights/beam_light.h"

#include "scene/lights/light_bounds.h"

#include <cmath>

namespace sheaf {

Vec3f BeamLightKind::power(const SceneView&, const LightRow& light) { return emitted_rgb(light); }

/// Zero power: next-event estimation never reaches a beam.
LightBounds BeamLightKind::bounds(const SceneView&, const LightRow& light, double) {
  const auto beam = light.data<BeamLightData>();
  return spot_light_bounds(beam.position, beam.direction, 1, 0);
}

std::optional<CompiledLight> BeamDescription::compile(const SourceLocation& where, LightContext& context) const {
  const Vec3f along = to_world.vector({0, 0, 1});
  const float length = sheaf::length(along);
  if (!(length > 0.0f) || !std::isfinite(length)) throw SceneError(where, "the direction of the beam has no length");
  const BeamLightData<Scalar> data{to_world.point({0, 0, 0}), along * (1.0f / length)};
  return context.light(context.emission(power, where), data);
}

}  // namespace sheaf
