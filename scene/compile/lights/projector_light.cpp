// Projectors: row, power and bounds.
#include "scene/compile/compile_materials.h"
#include "scene/compile/light.h"
#include "scene/compile/lights/light_rotation.h"
#include "scene/compile/lights/texture_mean.h"
#include "scene/description/field_of_view.h"

#include <cmath>

namespace sheaf {

namespace {

struct ProjectorRows {
  static constexpr LightDomain kDomain = LightDomain::kBounded;

  static Vec3f power(const SceneView&, const LightRow& light) { return emitted_rgb(light); }

  static LightBounds bounds(const SceneView& scene, const LightRow& light, double power) {
    const LightFrameRow& frame = scene.lights.frames[light.frame()];
    const Vec2f scale = frame.picture_scale();
    const double tangent = 0.5 * std::hypot(1.0 / scale.x, 1.0 / scale.y);  // of a corner
    return frame_light_bounds(frame, light.position, 1.0 / std::sqrt(1.0 + tangent * tangent), power);
  }

  /// Integral of the intensity over all directions for LightRecord::radiance 1: the integral of the image over its
  /// rectangle at distance 1, times the cube of the cosine if is_even().
  static Vec3f integral(const SceneView& scene, const LightRow& light, int points) {
    const Vec2f scale = scene.lights.frames[light.frame()].picture_scale();
    const float area = 1.0f / (scale.x * scale.y);
    const LightFrameRow& frame = scene.lights.frames[light.frame()];
    if (light.texture == kNone && !frame.is_even()) return {area, area, area};
    TextureMean mean(scene, light.texture);
    double weights = 0;
    for (int k = 0; k < points; ++k) {
      const Vec2f at = spread_point(k);
      const double x = (0.5 - double{at.x}) / double{scale.x}, y = (0.5 - double{at.y}) / double{scale.y};
      const double weight = frame.is_even() ? std::pow(1 + x * x + y * y, -1.5) : 1.0;
      weights += weight;
      if (light.texture != kNone) mean.add({at, 0, 0, 0, 0}, weight);
    }
    const float all = area * static_cast<float>(weights / points);
    return light.texture == kNone ? Vec3f{all, all, all} : mean.value() * all;
  }

  static IntegralSharing integral_key(const SceneView& scene, const LightRow& light, std::vector<std::uint32_t>& key) {
    const LightFrameRow& frame = scene.lights.frames[light.frame()];
    const Vec2f scale = frame.picture_scale();
    key.insert(key.end(), {float_bits(scale.x), float_bits(scale.y), frame.is_even() ? 1u : 0u});
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
  CompiledLight light{make_light_row(LightKind::kProjector, color * scale, origin), frame_of(rotation, origin)};
  if (constant == nullptr) light.row.texture = static_cast<std::uint32_t>(std::get<TextureId>(projector.irradiance));
  const double half_width = half_width_of(projector.fov, projector.fov_axis, aspect, 1.0, l.where);
  light.frame->set_picture_scale({static_cast<float>(0.5 / half_width), static_cast<float>(0.5 * aspect / half_width)});
  light.frame->cot_cutoff = projector.is_even ? 1.0f : 0.0f;
  light.spectrum = l.context.emission_row(projector.irradiance, l.where);
  light.spectrum.scale *= scale;
  return light;
}

}  // namespace sheaf
