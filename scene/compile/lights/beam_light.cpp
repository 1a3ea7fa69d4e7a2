// Beams of light along a ray: row, power and bounds.
#include "scene/lights/beam_light.h"
#include "scene/compile/compile_materials.h"
#include "scene/compile/light.h"

#include <cmath>

namespace sheaf {

namespace {

struct BeamRows {
  static constexpr LightDomain kDomain = LightDomain::kBounded;

  static Vec3f power(const SceneView&, const LightRow& light) { return emitted_rgb(light); }

  /// Zero power: next-event estimation never reaches a beam.
  static LightBounds bounds(const SceneView&, const LightRow& light, double) {
    const auto beam = light.data<BeamLightData>();
    return spot_light_bounds(beam.position, beam.direction, 1, 0);
  }
};

}  // namespace

LightCompiler light_compiler(LightTag<LightKind::kBeam>) { return make_light_compiler<BeamRows>(); }

std::optional<CompiledLight> place_light(const LightToPlace<BeamDescription>& l) {
  const Vec3f along = l.light.to_world.vector({0, 0, 1});
  const float length = sheaf::length(along);
  if (!(length > 0.0f) || !std::isfinite(length)) throw SceneError(l.where, "the direction of the beam has no length");
  const BeamLightData<Scalar> data{l.light.to_world.point({0, 0, 0}), along * (1.0f / length)};
  return CompiledLight{make_light_row(LightKind::kBeam, emission_rgb(l.light.power), data),
                       l.context.emission_row(l.light.power, l.where)};
}

}  // namespace sheaf
