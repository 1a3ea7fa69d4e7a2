#include "scene/lights/constant_light.h"

#include "scene/lights/light_context.h"
#include "scene/tables/scene.h"
#include "scene/xml/properties.h"

namespace sheaf {

void ConstantLightKind::read(Properties& p, LightDescription& light) {
  light.model =
      ConstantLightDescription{p.spectrum("radiance", SpectrumDescription::constant(1), SpectrumRole::kEmission)};
}

Vec3f ConstantLightKind::power(const SceneView& scene, const LightRow& light) {
  const float disk = kPi * scene.radius * scene.radius;
  return emitted_rgb(light) * (4 * kPi * disk);
}

std::optional<CompiledLight> place_light(const ConstantLightDescription& light, const SourceLocation& where,
                                         LightContext& context) {
  const LightEmission emission = context.emission(light.radiance, where);
  return CompiledLight{make_light_row(kLightKind<ConstantLightKind>, emission.rgb), emission.spectrum};
}

}  // namespace sheaf
