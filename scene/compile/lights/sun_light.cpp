// Suns: row and power. A sun of radius 0 becomes a directional light.
#include "scene/lights/sun_light.h"
#include "scene/compile/daylight.h"
#include "scene/compile/light.h"
#include "scene/lights/directional_light.h"

#include <cmath>

namespace sheaf {

namespace {

struct SunRows {
  static constexpr LightDomain kDomain = LightDomain::kDistant;

  static Vec3f power(const SceneView& scene, const LightRow& light) {
    const float disk = kPi * scene.radius * scene.radius;
    return emitted_rgb(light) * (2 * kPi * light.data<SunLightData>().one_minus_cos * disk);
  }
};

/// 1 - cos of an angle in degrees, without cancellation.
double one_minus_cos(double degrees) {
  const double half = std::sin(0.5 * degrees * (double(kPi) / 180));
  return 2 * half * half;
}

}  // namespace

LightCompiler light_compiler(LightTag<LightKind::kSun>) { return make_light_compiler<SunRows>(); }

std::optional<CompiledLight> place_light(const LightToPlace<SunDescription>& l) {
  const SunDescription& sun = l.light;
  const double height = dot(sun.up, sun.direction);
  if (!(height >= 0.0)) {
    l.context.warnings.push_back(SceneError(l.where, "the sun is below the horizon and does not shine").what());
    return std::nullopt;
  }
  const bool disk = sun.radius > 0.0f;
  // The irradiance does not depend on the radius.
  const double own = one_minus_cos(double(SunDescription::kSunRadius)), seen = one_minus_cos(double(sun.radius));
  const double scale = double(sun.scale) * (disk ? own / seen : 2 * double(kPi) * own);
  SpectrumDescription::Table spectrum = sun_spectrum(sun.turbidity, std::asin(std::min(height, 1.0)));
  for (float& value : spectrum.values) value = static_cast<float>(value * scale);
  const Vec3f direction = stretched(sun.direction, sun.up, sun.stretch);
  const Vec3f rgb = sun_rgb(spectrum);
  const SunLightData<Scalar> data{direction, static_cast<float>(seen)};
  return CompiledLight{disk ? make_light_row(LightKind::kSun, rgb, data)
                            : make_light_row(LightKind::kDirectional, rgb, DirectionalLightData<Scalar>{direction}),
                       l.context.emission_row({SpectrumDescription{std::move(spectrum)}}, l.where)};
}

}  // namespace sheaf
