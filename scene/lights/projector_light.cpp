#include "scene/lights/projector_light.h"

#include "scene/description/field_of_view.h"
#include "scene/lights/light_bounds.h"
#include "scene/lights/light_context.h"
#include "scene/lights/light_rotation.h"
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

Vec3f ProjectorLightKind::power(const SceneView&, const LightRow& light) { return emitted_rgb(light); }

LightBounds ProjectorLightKind::bounds(const SceneView& scene, const LightRow& light, double power) {
  const auto projector = light.data<ProjectorLightData>();
  const Vec2f scale = projector.image_scale;
  const double tangent = 0.5 * std::hypot(1.0 / scale.x, 1.0 / scale.y);  // of a corner
  return frame_light_bounds(scene.lights.frames[projector.frame], projector.position,
                            1.0 / std::sqrt(1.0 + tangent * tangent), power);
}

/// Integral of the intensity over all directions for LightRecord::radiance 1: the integral of the image over its
/// rectangle at distance 1, times the cube of the cosine if kIsEven.
Vec3f ProjectorLightKind::integral(const SceneView& scene, const LightRow& light, int points) {
  const Vec2f scale = light.data<ProjectorLightData>().image_scale;
  const float area = 1.0f / (scale.x * scale.y);
  const bool is_even = light.has_flag(kIsEven);
  if (light.texture == kNone && !is_even) return {area, area, area};
  TextureMean mean(scene, light.texture);
  double weights = 0;
  for (int k = 0; k < points; ++k) {
    const Vec2f at = spread_point(k);
    const double x = (0.5 - double{at.x}) / double{scale.x}, y = (0.5 - double{at.y}) / double{scale.y};
    const double weight = is_even ? std::pow(1 + x * x + y * y, -1.5) : 1.0;
    weights += weight;
    if (light.texture != kNone) mean.add({at, 0, 0, 0, 0}, weight);
  }
  const float all = area * static_cast<float>(weights / points);
  return light.texture == kNone ? Vec3f{all, all, all} : mean.value() * all;
}

IntegralSharing ProjectorLightKind::integral_key(const SceneView&, const LightRow& light,
                                                 std::vector<std::uint32_t>& key) {
  const Vec2f scale = light.data<ProjectorLightData>().image_scale;
  key.insert(key.end(), {float_bits(scale.x), float_bits(scale.y), light.flags & kIsEven});
  return IntegralSharing::kShared;
}

Vec3f ProjectorLightKind::position(const LightRow& light) { return light.data<ProjectorLightData>().position; }

std::optional<CompiledLight> place_light(const ProjectorDescription& projector, const SourceLocation& where,
                                         LightContext& context) {
  const auto* image = std::get_if<TextureId>(&projector.irradiance);
  const std::uint32_t texture = image != nullptr ? context.texture_row(*image, where) : kNone;
  const double aspect = image != nullptr ? aspect_of(context.textures[texture]) : 1;
  const std::array<double, 9> rotation = rotation_of(projector.to_world, "a projector", where);
  const double half_width = half_width_of(projector.fov, projector.fov_axis, aspect, 1.0, where);
  LightEmission emission = context.emission(projector.irradiance, where);
  const float scale = projector.is_even ? projector.scale : kPi * projector.scale;
  emission.spectrum.scale *= scale;
  const Vec3f origin = projector.to_world.point({0, 0, 0});
  const ProjectorLightData<Scalar> data{
      origin,
      context.add_frame(frame_of(rotation, origin)),
      {static_cast<float>(0.5 / half_width), static_cast<float>(0.5 * aspect / half_width)}};
  CompiledLight out{make_light_row(kLightKind<ProjectorLightKind>, emission.rgb * scale, data), emission.spectrum};
  out.row.texture = texture;
  if (projector.is_even) out.row.flags |= kIsEven;
  return out;
}

}  // namespace sheaf
