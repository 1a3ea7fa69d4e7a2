// Goniometric lights, point lights with an image of all directions: row, power and bounds.
#include "scene/lights/goniometric_light.h"
#include "scene/compile/compile_materials.h"
#include "scene/compile/light.h"
#include "scene/compile/lights/light_rotation.h"
#include "scene/compile/lights/texture_mean.h"

namespace sheaf {

namespace {

struct GoniometricRows {
  static constexpr LightDomain kDomain = LightDomain::kBounded;

  static Vec3f power(const SceneView&, const LightRow& light) { return emitted_rgb(light) * (4 * kPi); }

  /// As for a point light of constant intensity.
  static LightBounds bounds(const SceneView&, const LightRow& light, double power) {
    return point_light_bounds(light.data<GoniometricLightData>().position,
                              static_cast<float>(power * (0.25 * double(kInvPi))));
  }

  /// Mean of the image over all directions; the map is equal-area, so all texels have the same weight.
  static Vec3f integral(const SceneView& scene, const LightRow& light, int points) {
    TextureMean mean(scene, light.texture);
    for (int k = 0; k < points; ++k) mean.add({spread_point(k), 0, 0, 0, 0}, 1.0);
    return mean.value();
  }

  static IntegralSharing integral_key(const SceneView&, const LightRow&, std::vector<std::uint32_t>&) {
    return IntegralSharing::kAll;
  }
};

}  // namespace

LightCompiler light_compiler(LightTag<LightKind::kGoniometric>) { return make_light_compiler<GoniometricRows>(); }

std::optional<CompiledLight> place_light(const LightToPlace<GoniometricLightDescription>& l) {
  const GoniometricLightDescription& source = l.light;
  const std::array<double, 9> rotation = rotation_of(source.to_world, "a goniometric light", l.where);
  const Vec3f origin = source.to_world.point({0, 0, 0});
  const GoniometricLightData<Scalar> data{origin, l.context.add_frame(frame_of(rotation, origin))};
  CompiledLight light{make_light_row(LightKind::kGoniometric, emission_rgb(source.intensity), data),
                      l.context.emission_row(source.intensity, l.where)};
  light.row.texture = l.context.texture_row(source.picture, l.where);
  return light;
}

}  // namespace sheaf
