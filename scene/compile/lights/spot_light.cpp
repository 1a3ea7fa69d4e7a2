// Spot lights with both falloffs: rows, power and bounds.
#include "scene/compile/compile_materials.h"
#include "scene/compile/light.h"
#include "scene/compile/lights/texture_mean.h"

#include <algorithm>
#include <cmath>

namespace sheaf {

namespace {

constexpr double kPiDouble = 3.14159265358979323846;
constexpr double kDegree = kPiDouble / 180.0;

LightFrameRow frame_row(const Transform& to_world) {
  const auto& inverse = to_world.inverse_matrix().m;
  float m[12];
  for (std::size_t i = 0; i < 12; ++i) m[i] = static_cast<float>(inverse[i / 4][i % 4] / inverse[3][3]);
  LightFrameRow row;
  row.row_x = {m[0], m[1], m[2]}, row.offset_x = m[3];
  row.row_y = {m[4], m[5], m[6]}, row.offset_y = m[7];
  row.row_z = {m[8], m[9], m[10]}, row.offset_z = m[11];
  return row;
}

/// Spot lights with linear falloff, or with a smooth step.
template <bool Linear> struct SpotRows {
  static constexpr LightDomain kDomain = LightDomain::kBounded;

  static Vec3f power(const SceneView&, const LightRow& light) { return emitted_rgb(light); }

  static LightBounds bounds(const SceneView& scene, const LightRow& light, double power) {
    const LightFrameRow& frame = scene.lights.frames[light.frame()];
    const double cos_total = Linear ? std::cos(double(frame.cutoff)) : frame.cutoff;
    return frame_light_bounds(frame, light.position, cos_total, power);
  }

  /// Integral of the intensity over all directions for intensity 1.
  static Vec3f integral(const SceneView& scene, const LightRow& light, int points) {
    const LightFrameRow& frame = scene.lights.frames[light.frame()];
    const double cutoff = Linear ? frame.cutoff : std::acos(std::clamp(double(frame.cutoff), -1.0, 1.0));
    TextureMean mean(scene, light.texture);
    double sum = 0;
    // Rings are cheap without a texture.
    const int rings = light.texture == kNone ? kMeanPoints / 8 : points / 8;
    for (int i = 0; i < rings; ++i) {
      const double theta = (i + 0.5) / rings * cutoff;
      const double weight = falloff(frame, theta) * std::sin(theta) * cutoff / rings;
      sum += weight;
      if (light.texture == kNone) continue;
      constexpr int kAround = 32;
      for (int j = 0; j < kAround; ++j) {
        const double phi = 2.0 * kPiDouble * (j + 0.5 + 0.618 * i) / kAround;
        const double r = 0.5 * std::tan(theta) * frame.cot_cutoff;
        const Vec2f uv{static_cast<float>(0.5 + r * std::cos(phi)), static_cast<float>(0.5 + r * std::sin(phi))};
        mean.add({uv, 0, 0, 0, 0}, weight);
      }
    }
    const auto whole = static_cast<float>(2.0 * kPiDouble * sum);
    return light.texture == kNone ? Vec3f{whole, whole, whole} : mean.value() * whole;
  }

  static IntegralSharing integral_key(const SceneView& scene, const LightRow& light, std::vector<std::uint32_t>& key) {
    const LightFrameRow& frame = scene.lights.frames[light.frame()];
    key.insert(key.end(), {float_bits(frame.cutoff), float_bits(frame.slope), float_bits(frame.cot_cutoff)});
    return IntegralSharing::kAll;
  }

 private:
  /// Relative intensity at an angle from the axis.
  static double falloff(const LightFrameRow& frame, double theta) {
    if (Linear) return std::clamp((frame.cutoff - theta) * frame.slope, 0.0, 1.0);
    const double t = std::clamp((std::cos(theta) - frame.cutoff) * frame.slope, 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
  }
};

void check_angles(const SpotLightDescription& spot, const SourceLocation& where) {
  if (!(spot.cutoff_angle > 0.0f && spot.cutoff_angle <= 180.0f))
    throw SceneError(where, "the cone of a spot light must lie between 0 and 180 degrees, found " +
                                std::to_string(spot.cutoff_angle));
  if (!(spot.beam_width >= 0.0f && spot.beam_width <= spot.cutoff_angle))
    throw SceneError(where, "the beam of a spot light, found " + std::to_string(spot.beam_width) +
                                " degrees, must not be wider than its cone of " + std::to_string(spot.cutoff_angle));
  if (spot.texture && !(spot.cutoff_angle < 90.0f))
    throw SceneError(where, "the cone of a spot light with a texture must be below 90 degrees, found " +
                                std::to_string(spot.cutoff_angle));
}

}  // namespace

LightCompiler light_compiler(LightTag<LightKind::kSpot>) { return make_light_compiler<SpotRows<true>>(); }
LightCompiler light_compiler(LightTag<LightKind::kSmoothSpot>) { return make_light_compiler<SpotRows<false>>(); }

std::optional<CompiledLight> place_light(const LightToPlace<SpotLightDescription>& l) {
  const SpotLightDescription& spot = l.light;
  const double cutoff = spot.cutoff_angle * kDegree, beam = spot.beam_width * kDegree;
  if (spot.texture) l.context.texture_row(*spot.texture, l.where);
  check_angles(spot, l.where);
  const bool smooth = spot.falloff == SpotLightDescription::Falloff::kSmooth;
  LightFrameRow frame = frame_row(spot.to_world);
  // Avoids division by zero for a step of zero width.
  constexpr double kMinWidth = 1e-7;
  const double outer = smooth ? std::cos(cutoff) : cutoff;
  const double width = smooth ? std::cos(beam) - std::cos(cutoff) : cutoff - beam;
  frame.cutoff = static_cast<float>(outer);
  frame.slope = static_cast<float>(1.0 / std::max(width, kMinWidth));
  frame.cot_cutoff = static_cast<float>(1.0 / std::tan(std::min(cutoff, 89.999 * kDegree)));
  CompiledLight light{make_light_row(smooth ? LightKind::kSmoothSpot : LightKind::kSpot, emission_rgb(spot.intensity),
                                     spot.to_world.point({0, 0, 0})),
                      frame, l.context.emission_row(spot.intensity, l.where)};
  if (spot.texture) light.row.texture = static_cast<std::uint32_t>(*spot.texture);
  return light;
}

}  // namespace sheaf
