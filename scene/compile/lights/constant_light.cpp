// Constant environment lights: row and power.
#include "scene/compile/compile_materials.h"
#include "scene/compile/light.h"

namespace sheaf {

namespace {

struct ConstantRows {
  static constexpr LightDomain kDomain = LightDomain::kEnvironment;

  static Vec3f power(const SceneView& scene, const LightRow& light) {
    const float disk = kPi * scene.radius * scene.radius;
    return emitted_rgb(light) * (4 * kPi * disk);
  }
};

}  // namespace

LightCompiler light_compiler(LightTag<LightKind::kConstant>) { return make_light_compiler<ConstantRows>(); }

std::optional<CompiledLight> place_light(const LightToPlace<ConstantLightDescription>& l) {
  return CompiledLight{make_light_row(LightKind::kConstant, emission_rgb(l.light.radiance)),
                       l.context.emission_row(l.light.radiance, l.where)};
}

}  // namespace sheaf
