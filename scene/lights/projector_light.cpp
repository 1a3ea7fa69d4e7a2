#include "scene/lights/projector_light.h"

#include "scene/description/field_of_view.h"
#include "scene/lights/light_bounds.h"
#include "scene/lights/texture_mean.h"
#include "scene/textures/list.h"

#include <cmath>

namespace sheaf {

namespace {

/// Aspect ratio of a texture, width over height.
double aspect_of(const TextureRow& row) {
  if (row.kind != kTextureKind<BitmapDescription>) return 1;
  const auto bitmap = row.data<BitmapRow>();
  return double(bitmap.width) / bitmap.height;
}

}  // namespace

LightBounds ProjectorLightKind::bounds(const SceneView& scene, const LightRow& light, double power) {
  const auto projector = light.data<ProjectorLightData>();
  const Vec2f scale = projector.image_scale;
  const double tangent = 0.5 * std::hypot(1.0 / scale.x, 1.0 / scale.y);  // of a corner
  return frame_light_bounds(scene.lights.frames[projector.frame], projector.position,
                            1.0 / std::sqrt(1.0 + tangent * tangent), power);
}

/// Integral of the intensity over all directions for LightRecord::radiance 1: the integral of the image over its
/// rectangle at distance 1, times the cube of the cosine if kConstantIntensity.
Vec3f ProjectorLightKind::integral(const SceneView& scene, const LightRow& light, int points) {
  const Vec2f scale = light.data<ProjectorLightData>().image_scale;
  const float area = 1.0f / (scale.x * scale.y);
  const bool constant_intensity = light.has_flag(kConstantIntensity);
  if (light.texture == kNone && !constant_intensity) return {area, area, area};
  TextureMean mean(scene, light.texture);
  double weights = 0;
  for (int k = 0; k < points; ++k) {
    const Vec2f at = spread_point(k);
    const double x = (0.5 - double{at.x}) / double{scale.x}, y = (0.5 - double{at.y}) / double{scale.y};
    const double weight = constant_intensity ? std::pow(1 + x * x + y * y, -1.5) : 1.0;
    weights += weight;
    if (light.texture != kNone) mean.add({at, 0, 0, 0, 0}, weight);
  }
  const float all = area * static_cast<float>(weights / points);
  return light.texture == kNone ? Vec3f{all, all, all} : mean.value() * all;
}

IntegralSharing ProjectorLightKind::integral_key(const SceneView&, const LightRow& light,
                                                 std::vector<std::uint32_t>& key) {
  const Vec2f scale = light.data<ProjectorLightData>().image_scale;
  key.insert(key.end(), {float_bits(scale.x), float_bits(scale.y), light.flags & kConstantIntensity});
  return IntegralSharing::kShared;
}

std::optional<CompiledLight> ProjectorDescription::compile(const SourceLocation& where, LightContext& context) const {
  const auto* image = std::get_if<TextureId>(&irradiance);
  const std::uint32_t texture = image != nullptr ? context.texture_row(*image, where) : kNone;
  const double aspect = image != nullptr ? aspect_of(context.textures[texture]) : 1;
  const double half_width = half_width_of(fov, fov_axis, aspect, 1.0, where);
  LightEmission emission = context.emission(irradiance, where);
  const float factor = constant_intensity ? scale : kPi * scale;
  emission.rgb = emission.rgb * factor;
  emission.spectrum.scale *= factor;
  const ProjectorLightData<Scalar> data{
      rotated_frame(to_world, "a projector", where, context),
      {static_cast<float>(0.5 / half_width), static_cast<float>(0.5 * aspect / half_width)}};
  CompiledLight out = context.light(emission, data);
  out.row.texture = texture;
  if (constant_intensity) out.row.flags |= kConstantIntensity;
  return out;
}

}  // namespace sheaf
