#include "scene/lights/spot_light.h"

#include "scene/lights/light_bounds.h"
#include "scene/lights/list.h"
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

double cutoff_angle_of(const SpotLightData<Scalar>& spot, bool smooth) {
  return smooth ? std::acos(std::clamp(double(spot.cutoff), -1.0, 1.0)) : double(spot.cutoff);
}

/// Relative intensity at an angle from the axis.
double falloff(const SpotLightData<Scalar>& spot, bool smooth, double theta) {
  if (!smooth) return std::clamp((spot.cutoff - theta) * spot.inverse_width, 0.0, 1.0);
  const double t = std::clamp((std::cos(theta) - spot.cutoff) * spot.inverse_width, 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

void check_angles(const SpotLightDescription& spot, const SourceLocation& where) {
  if (!(spot.cutoff_angle > 0.0f && spot.cutoff_angle <= 180.0f))
    throw SceneError(
        where, fmt::format("the cone of a spot light must lie between 0 and 180 degrees, found {}", spot.cutoff_angle));
  if (!(spot.beam_width >= 0.0f && spot.beam_width <= spot.cutoff_angle))
    throw SceneError(where,
                     fmt::format("the beam of a spot light, found {} degrees, must not be wider than its cone of {}",
                                 spot.beam_width, spot.cutoff_angle));
  if (spot.texture && !(spot.cutoff_angle < 90.0f))
    throw SceneError(where, fmt::format("the cone of a spot light with a texture must be below 90 degrees, found {}",
                                        spot.cutoff_angle));
}

}  // namespace

template <bool kSmooth>
LightBounds SpotLightKind<kSmooth>::bounds(const SceneView& scene, const LightRow& light, double power) {
  const auto spot = light.data<SpotLightData>();
  const double cos_total = kSmooth ? double(spot.cutoff) : std::cos(double(spot.cutoff));
  return frame_light_bounds(scene.lights.frames[spot.frame], spot.position, cos_total, power);
}

/// Integral of the intensity over all directions for intensity 1.
template <bool kSmooth>
Vec3f SpotLightKind<kSmooth>::integral(const SceneView& scene, const LightRow& light, int points) {
  const auto spot = light.data<SpotLightData>();
  const double cutoff = cutoff_angle_of(spot, kSmooth);
  TextureMean mean(scene, light.texture);
  double sum = 0;
  // Rings are cheap without a texture.
  const int rings = light.texture == kNone ? kMeanPoints / 8 : points / 8;
  for (int i = 0; i < rings; ++i) {
    const double theta = (i + 0.5) / rings * cutoff;
    const double weight = falloff(spot, kSmooth, theta) * std::sin(theta) * cutoff / rings;
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

template <bool kSmooth>
IntegralSharing SpotLightKind<kSmooth>::integral_key(const SceneView&, const LightRow& light,
                                                     std::vector<std::uint32_t>& key) {
  const auto spot = light.data<SpotLightData>();
  key.insert(key.end(), {float_bits(spot.cutoff), float_bits(spot.inverse_width), float_bits(spot.cot_cutoff)});
  return IntegralSharing::kShared;
}

template struct SpotLightKind<false>;
template struct SpotLightKind<true>;

std::optional<CompiledLight> SpotLightDescription::compile(const SourceLocation& where, LightContext& context) const {
  const double cutoff = cutoff_angle * kDegree, beam = beam_width * kDegree;
  const std::uint32_t texture_row = texture ? context.texture_row(*texture, where) : kNone;
  check_angles(*this, where);
  const bool smooth = falloff == Falloff::kSmooth;
  // Avoids division by zero for a step of zero width.
  constexpr double kMinWidth = 1e-7;
  const double outer = smooth ? std::cos(cutoff) : cutoff;
  const double width = smooth ? std::cos(beam) - std::cos(cutoff) : cutoff - beam;
  const auto limit = static_cast<float>(outer), inverse_width = static_cast<float>(1.0 / std::max(width, kMinWidth));
  const auto cot_cutoff = static_cast<float>(1.0 / std::tan(std::min(cutoff, 89.999 * kDegree)));
  const LightEmission emission = context.emission(intensity, where);
  const Vec3f position = to_world.point({0, 0, 0});
  const SpotLightData<Scalar> data{
      {position, context.add_frame(frame_row(to_world))}, limit, inverse_width, cot_cutoff};
  const LightKind kind = smooth ? kLightKind<SmoothSpotLightKind> : kLightKind<LinearSpotLightKind>;
  CompiledLight out{make_light_row(kind, emission.rgb, data), emission.spectrum};
  out.row.texture = texture_row;
  return out;
}

}  // namespace sheaf
