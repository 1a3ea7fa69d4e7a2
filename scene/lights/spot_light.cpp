#include "scene/lights/spot_light.h"

#include "scene/lights/light_bounds.h"
#include "scene/lights/light_context.h"
#include "scene/lights/texture_mean.h"

#include <algorithm>
#include <cmath>

namespace sheaf {

namespace {

constexpr double kTwoPi = 2.0 * 3.14159265358979323846, kDegree = 3.14159265358979323846 / 180.0;

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

using LinearSpot = LinearSpotLightData<Scalar>;
using SmoothSpot = SmoothSpotLightData<Scalar>;

double cutoff_angle_of(const LinearSpot& spot) { return spot.cutoff_angle; }
double cutoff_angle_of(const SmoothSpot& spot) { return std::acos(std::clamp(double(spot.cos_cutoff), -1.0, 1.0)); }

/// Relative intensity at an angle from the axis.
double falloff(const LinearSpot& spot, double theta) {
  return std::clamp((spot.cutoff_angle - theta) * spot.inverse_width, 0.0, 1.0);
}
double falloff(const SmoothSpot& spot, double theta) {
  const double t = std::clamp((std::cos(theta) - spot.cos_cutoff) * spot.inverse_width, 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

/// Integral of the intensity over all directions for intensity 1.
template <class Spot> Vec3f integral_of(const Spot& spot, const SceneView& scene, const LightRow& light, int points) {
  const double cutoff = cutoff_angle_of(spot);
  TextureMean mean(scene, light.texture);
  double sum = 0;
  // Rings are cheap without a texture.
  const int rings = light.texture == kNone ? kMeanPoints / 8 : points / 8;
  for (int i = 0; i < rings; ++i) {
    const double theta = (i + 0.5) / rings * cutoff;
    const double weight = falloff(spot, theta) * std::sin(theta) * cutoff / rings;
    sum += weight;
    if (light.texture == kNone) continue;
    constexpr int kAround = 32;
    for (int j = 0; j < kAround; ++j) {
      const double phi = kTwoPi * (j + 0.5 + 0.618 * i) / kAround;
      const double r = 0.5 * std::tan(theta) * spot.cot_cutoff;
      const Vec2f uv{static_cast<float>(0.5 + r * std::cos(phi)), static_cast<float>(0.5 + r * std::sin(phi))};
      mean.add({uv, 0, 0, 0, 0}, weight);
    }
  }
  const auto whole = static_cast<float>(kTwoPi * sum);
  return light.texture == kNone ? Vec3f{whole, whole, whole} : mean.value() * whole;
}

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

Vec3f LinearSpotLightKind::power(const SceneView&, const LightRow& light) { return emitted_rgb(light); }

LightBounds LinearSpotLightKind::bounds(const SceneView& scene, const LightRow& light, double power) {
  const LinearSpot spot = light.data<LinearSpotLightData>();
  return frame_light_bounds(scene.lights.frames[spot.frame], spot.position, std::cos(double(spot.cutoff_angle)), power);
}

Vec3f LinearSpotLightKind::integral(const SceneView& scene, const LightRow& light, int points) {
  return integral_of(light.data<LinearSpotLightData>(), scene, light, points);
}

IntegralSharing LinearSpotLightKind::integral_key(const SceneView&, const LightRow& light,
                                                  std::vector<std::uint32_t>& key) {
  const LinearSpot spot = light.data<LinearSpotLightData>();
  key.insert(key.end(), {float_bits(spot.cutoff_angle), float_bits(spot.inverse_width), float_bits(spot.cot_cutoff)});
  return IntegralSharing::kShared;
}

Vec3f LinearSpotLightKind::position(const LightRow& light) { return light.data<LinearSpotLightData>().position; }

Vec3f SmoothSpotLightKind::power(const SceneView&, const LightRow& light) { return emitted_rgb(light); }

LightBounds SmoothSpotLightKind::bounds(const SceneView& scene, const LightRow& light, double power) {
  const SmoothSpot spot = light.data<SmoothSpotLightData>();
  return frame_light_bounds(scene.lights.frames[spot.frame], spot.position, double(spot.cos_cutoff), power);
}

Vec3f SmoothSpotLightKind::integral(const SceneView& scene, const LightRow& light, int points) {
  return integral_of(light.data<SmoothSpotLightData>(), scene, light, points);
}

IntegralSharing SmoothSpotLightKind::integral_key(const SceneView&, const LightRow& light,
                                                  std::vector<std::uint32_t>& key) {
  const SmoothSpot spot = light.data<SmoothSpotLightData>();
  key.insert(key.end(), {float_bits(spot.cos_cutoff), float_bits(spot.inverse_width), float_bits(spot.cot_cutoff)});
  return IntegralSharing::kShared;
}

Vec3f SmoothSpotLightKind::position(const LightRow& light) { return light.data<SmoothSpotLightData>().position; }

std::optional<CompiledLight> place_light(const SpotLightDescription& spot, const SourceLocation& where,
                                         LightContext& context) {
  const double cutoff = spot.cutoff_angle * kDegree, beam = spot.beam_width * kDegree;
  const std::uint32_t texture = spot.texture ? context.texture_row(*spot.texture, where) : kNone;
  check_angles(spot, where);
  const bool smooth = spot.falloff == SpotLightDescription::Falloff::kSmooth;
  // Avoids division by zero for a step of zero width.
  constexpr double kMinWidth = 1e-7;
  const double outer = smooth ? std::cos(cutoff) : cutoff;
  const double width = smooth ? std::cos(beam) - std::cos(cutoff) : cutoff - beam;
  const auto limit = static_cast<float>(outer), inverse_width = static_cast<float>(1.0 / std::max(width, kMinWidth));
  const auto cot_cutoff = static_cast<float>(1.0 / std::tan(std::min(cutoff, 89.999 * kDegree)));
  const LightEmission emission = context.emission(spot.intensity, where);
  const Vec3f position = spot.to_world.point({0, 0, 0});
  const std::uint32_t frame = context.add_frame(frame_row(spot.to_world));
  const SmoothSpot smooth_spot{position, frame, limit, inverse_width, cot_cutoff};
  const LinearSpot linear_spot{position, frame, limit, inverse_width, cot_cutoff};
  CompiledLight out{smooth ? make_light_row(kLightKind<SmoothSpotLightKind>, emission.rgb, smooth_spot)
                           : make_light_row(kLightKind<LinearSpotLightKind>, emission.rgb, linear_spot),
                    emission.spectrum};
  out.row.texture = texture;
  return out;
}

}  // namespace sheaf
