#include "scene/lights/sun_light.h"

#include "scene/lights/daylight.h"
#include "scene/lights/list.h"

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
  return emitted_rgb(light) * (2 * kPi * light.data<SunLightData>().one_minus_cos * scene_disk_area(scene));
}

std::optional<CompiledLight> SunDescription::compile(const SourceLocation& where, LightContext& context) const {
  const double height = dot(up, direction);
  if (!(height >= 0.0)) {
    context.warnings.push_back(SceneError(where, "the sun is below the horizon and does not shine").what());
    return std::nullopt;
  }
  const bool disk = radius > 0.0f;
  // The irradiance does not depend on the radius.
  const double own = one_minus_cos(double(kSunRadius)), seen = one_minus_cos(double(radius));
  const double factor = double(scale) * (disk ? own / seen : 2 * double(kPi) * own);
  SpectrumDescription::Table spectrum = sun_spectrum(turbidity, std::asin(std::min(height, 1.0)));
  for (float& value : spectrum.values) value = static_cast<float>(value * factor);
  const Vec3f to_sun = stretched(direction, up, stretch);
  const Vec3f rgb = sun_rgb(spectrum);
  const LightEmission emission{rgb, context.emission_row({SpectrumDescription{std::move(spectrum)}}, where)};
  if (disk) return context.light(emission, SunLightData<Scalar>{to_sun, static_cast<float>(seen)});
  return CompiledLight{make_light_row(kLightKind<DirectionalLightKind>, rgb, DirectionalLightData<Scalar>{to_sun}),
                       emission.spectrum};
}

}  // namespace sheaf
