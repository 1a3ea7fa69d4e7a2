// Projectors: row, power and bounds.
#include "scene/compile/compile_materials.h"
#include "scene/compile/light.h"
#include "scene/compile/lights/light_rotation.h"
#include "scene/compile/lights/texture_mean.h"

#include <cmath>

namespace sheaf {

namespace {

struct ProjectorRows {
  static constexpr LightReach kReach = LightReach::kBounded;

  static Vec3f power(const SceneView& scene, const LightRow& light) {
    return emitted_rgb(light) * integral(scene, light);
  }

  static LightBounds bounds(const SceneView& scene, const LightRow& light, double power) {
    const LightFrameRow& frame = scene.light_frames[light.frame()];
    const Vec2f scale = frame.picture_scale();
    const double tangent = 0.5 * std::hypot(1.0 / scale.x, 1.0 / scale.y);  // of a corner
    return frame_light_bounds(frame, light.position, 1.0 / std::sqrt(1.0 + tangent * tangent), power);
  }

 private:
  /// The picture's integral over its rectangle at distance 1.
  static Vec3f integral(const SceneView& scene, const LightRow& light) {
    const Vec2f scale = scene.light_frames[light.frame()].picture_scale();
    const float area = 1.0f / (scale.x * scale.y);
    if (light.texture == kNone) return {area, area, area};
    TextureMean mean(scene, light.texture);
    for (int k = 0; k < kMeanPoints; ++k) mean.add({spread_point(k), 0, 0, 0, 0}, 1.0);
    return mean.value() * area;
  }
};

/// Width over height of the picture.
double aspect_of(const LightToPlace<ProjectorDescription>& l) {
  const auto* id = std::get_if<TextureId>(&l.light.irradiance);
  if (id == nullptr) return 1;
  const TextureRow& row = l.context.textures[l.context.texture_row(*id, l.where)];
  return row.kind == TextureKind::kBitmap ? double(row.bitmap.width) / row.bitmap.height : 1;
}

}  // namespace

LightCompiler light_compiler(LightTag<LightKind::kProjector>) { return make_light_compiler<ProjectorRows>(); }

std::optional<PlacedLight> place_light(const LightToPlace<ProjectorDescription>& l) {
  const ProjectorDescription& projector = l.light;
  const double aspect = aspect_of(l);
  const std::array<double, 9> rotation = rotation_of(projector.to_world, "a projector", l.where);
  const auto* constant = std::get_if<SpectrumDescription>(&projector.irradiance);
  const Vec3f color = constant != nullptr ? emission_rgb(*constant) : Vec3f{1, 1, 1};
  const Vec3f origin = projector.to_world.point({0, 0, 0});
  PlacedLight light{make_light_row(LightKind::kProjector, color * (kPi * projector.scale), origin), LightFrameRow{}};
  if (constant == nullptr) light.row.texture = static_cast<std::uint32_t>(std::get<TextureId>(projector.irradiance));
  const double half_width = half_width_of(projector.fov, projector.fov_axis, aspect, 1.0, l.where);
  LightFrameRow& frame = *light.frame;
  Vec3f* const rows[3] = {&frame.row_x, &frame.row_y, &frame.row_z};
  float* const offsets[3] = {&frame.offset_x, &frame.offset_y, &frame.offset_z};
  for (std::size_t i = 0; i < 3; ++i) {
    const double* row = rotation.data() + 3 * i;
    *rows[i] = {static_cast<float>(row[0]), static_cast<float>(row[1]), static_cast<float>(row[2])};
    *offsets[i] = static_cast<float>(-(row[0] * origin.x + row[1] * origin.y + row[2] * origin.z));
  }
  frame.set_picture_scale({static_cast<float>(0.5 / half_width), static_cast<float>(0.5 * aspect / half_width)});
  light.spectrum = l.context.emission_row(projector.irradiance, l.where);
  light.spectrum.scale *= kPi * projector.scale;
  return light;
}

}  // namespace sheaf
