#include "scene/lights/sun_light.h"

#include "scene/lights/daylight.h"
#include "scene/lights/light_context.h"
#include "scene/tables/scene_view.h"

#include <cmath>

namespace sheaf {

namespace {

/// 1 - cos of an angle in degrees, without cancellation.
double one_minus_cos(double degrees) {
  const double half = std::sin(0.5 * degrees * (double(kPi) / 180));
  return 2 * half * half;
}

}  // namespace

Vec3f SunLightKind::power(const SceneView& scene, const LightRow& light) {
  const float disk = kPi * scene.radius * scene.radius;
  return emitted_rgb(light) * (2 * kPi * light.data<SunLightData>().one_minus_cos * disk);
}

std::optional<CompiledLight> place_light(const SunDescription& sun, const SourceLocation& where,
                                         LightContext& context) {
  const double height = dot(sun.up, sun.direction);
  if (!(height >= 0.0)) {
    context.warnings.push_back(SceneError(where, "the sun is below the horizon and does not shine").what());
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
  return CompiledLight{
      disk ? make_light_row(kLightKind<SunLightKind>, rgb, data)
           : make_light_row(kLightKind<DirectionalLightKind>, rgb, DirectionalLightData<Scalar>{direction}),
      context.emission_row({SpectrumDescription{std::move(spectrum)}}, where)};
}

}  // namespace sheaf
