#include "scene/lights/goniometric_light.h"

#include "scene/lights/light_bounds.h"
#include "scene/lights/texture_mean.h"

namespace sheaf {

Vec3f GoniometricLightKind::power(const SceneView&, const LightRow& light) { return emitted_rgb(light) * (4 * kPi); }

/// As for a point light of constant intensity.
LightBounds GoniometricLightKind::bounds(const SceneView&, const LightRow& light, double power) {
  return point_light_bounds(position(light), static_cast<float>(power * (0.25 * double(kInvPi))));
}

/// Mean of the image over all directions; the map is equal-area, so all texels have the same weight.
Vec3f GoniometricLightKind::integral(const SceneView& scene, const LightRow& light, int points) {
  TextureMean mean(scene, light.texture);
  for (int k = 0; k < points; ++k) mean.add({spread_point(k), 0, 0, 0, 0}, 1.0);
  return mean.value();
}

IntegralSharing GoniometricLightKind::integral_key(const SceneView&, const LightRow&, std::vector<std::uint32_t>&) {
  return IntegralSharing::kShared;
}

std::optional<CompiledLight> GoniometricLightDescription::compile(const SourceLocation& where,
                                                                  LightContext& context) const {
  const FramedLightData<Scalar> data = rotated_frame(to_world, "a goniometric light", where, context);
  CompiledLight out = context.light(context.emission(intensity, where), data);
  out.row.texture = context.texture_row(image, where);
  return out;
}

}  // namespace sheaf
