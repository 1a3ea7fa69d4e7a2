// Projectors: row, power and bounds.
#include "scene/lights/projector_light.h"
#include "scene/compile/compile_materials.h"
#include "scene/compile/light.h"
#include "scene/compile/lights/light_rotation.h"
#include "scene/compile/lights/texture_mean.h"

#include <cmath>

namespace sheaf {

namespace {

struct ProjectorRows {
  static constexpr LightDomain kDomain = LightDomain::kBounded;

  static Vec3f power(const SceneView&, const LightRow& light) { return emitted_rgb(light); }

  static LightBounds bounds(const SceneView& scene, const LightRow& light, double power) {
    const auto projector = light.data<ProjectorLightData>();
    const Vec2f scale = projector.image_scale;
    const double tangent = 0.5 * std::hypot(1.0 / scale.x, 1.0 / scale.y);  // of a corner
    return frame_light_bounds(scene.light_frames[projector.frame], projector.position,
                              1.0 / std::sqrt(1.0 + tangent * tangent), power);
  }

  /// Integral of the intensity over all directions for LightRecord::radiance 1: the integral of the image over its
  /// rectangle at distance 1, times the cube of the cosine if kIsEven.
  static Vec3f integral(const SceneView& scene, const LightRow& light, int points) {
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

  static IntegralSharing integral_key(const SceneView&, const LightRow& light, std::vector<std::uint32_t>& key) {
    const Vec2f scale = light.data<ProjectorLightData>().image_scale;
    key.insert(key.end(), {float_bits(scale.x), float_bits(scale.y), light.flags & kIsEven});
    return IntegralSharing::kAll;
  }
};

/// Aspect ratio of the image, width over height.
double aspect_of(const LightToPlace<ProjectorDescription>& l) {
  const auto* id = std::get_if<TextureId>(&l.light.irradiance);
  if (id == nullptr) return 1;
  const TextureRow& row = l.context.textures[l.context.texture_row(*id, l.where)];
  return row.kind == TextureKind::kBitmap ? double(row.bitmap.width) / row.bitmap.height : 1;
}

}  // namespace

LightCompiler light_compiler(LightTag<LightKind::kProjector>) { return make_light_compiler<ProjectorRows>(); }

std::optional<CompiledLight> place_light(const LightToPlace<ProjectorDescription>& l) {
  const ProjectorDescription& projector = l.light;
  const double aspect = aspect_of(l);
  const std::array<double, 9> rotation = rotation_of(projector.to_world, "a projector", l.where);
  const auto* constant = std::get_if<SpectrumDescription>(&projector.irradiance);
  const Vec3f color = constant != nullptr ? emission_rgb(*constant) : Vec3f{1, 1, 1};
  const Vec3f origin = projector.to_world.point({0, 0, 0});
  const float scale = projector.is_even ? projector.scale : kPi * projector.scale;
  const double half_width = half_width_of(projector.fov, projector.fov_axis, aspect, 1.0, l.where);
  const ProjectorLightData<Scalar> data{
      origin,
      l.context.add_frame(frame_of(rotation, origin)),
      {static_cast<float>(0.5 / half_width), static_cast<float>(0.5 * aspect / half_width)}};
  CompiledLight light{make_light_row(LightKind::kProjector, color * scale, data)};
  if (constant == nullptr) light.row.texture = static_cast<std::uint32_t>(std::get<TextureId>(projector.irradiance));
  if (projector.is_even) light.row.flags |= kIsEven;
  light.spectrum = l.context.emission_row(projector.irradiance, l.where);
  light.spectrum.scale *= scale;
  return light;
}

}  // namespace sheaf
