// Point lights: row, power and bounds.
#include "scene/lights/point_light.h"
#include "scene/compile/compile_materials.h"
#include "scene/compile/light.h"

namespace sheaf {

namespace {

struct PointRows {
  static constexpr LightDomain kDomain = LightDomain::kBounded;

  static Vec3f power(const SceneView&, const LightRow& light) { return emitted_rgb(light) * (4 * kPi); }

  static LightBounds bounds(const SceneView&, const LightRow& light, double power) {
    return point_light_bounds(light.data<PointLightData>().position,
                              static_cast<float>(power * (0.25 * double(kInvPi))));
  }
};

}  // namespace

LightCompiler light_compiler(LightTag<LightKind::kPoint>) { return make_light_compiler<PointRows>(); }

std::optional<CompiledLight> place_light(const LightToPlace<PointLightDescription>& l) {
  const PointLightData<Scalar> data{l.light.position};
  return CompiledLight{make_light_row(LightKind::kPoint, emission_rgb(l.light.intensity), data),
                       l.context.emission_row(l.light.intensity, l.where)};
}

}  // namespace sheaf
