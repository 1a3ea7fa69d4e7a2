// Shadow rays as Embree wants them: what the shadow and the transmittance stage share.
#pragma once

#include "core/quad.h"
#include "kernels/wave/wave.h"

namespace sheaf {

/// Shadow rays end this close to the light's point, which itself lies off the light's surface, so that rounding of the
/// direction cannot carry them into it.
inline constexpr float kShadowEnd = 1.0f - 4.0f * 5.9604645e-8f;

/// Copies the shadow rays [i, i + L::width) to the packet's lanes from `at` on.
template <class L> SHEAF_INLINE void pack_shadow_rays(const Wave& wave, int i, RayPacket& packet, int at) {
  const ShadowItem<Columns>& c = wave.shadows.columns();
  const auto copy = [i, at](const float* from, float* to) SHEAF_LAMBDA_INLINE {
    Float<L> value;
    load(from + i, value);
    store(to + at, value);
  };
  copy(c.origin.x, packet.origin_x);
  copy(c.origin.y, packet.origin_y);
  copy(c.origin.z, packet.origin_z);
  copy(c.direction.x, packet.direction_x);
  copy(c.direction.y, packet.direction_y);
  copy(c.direction.z, packet.direction_z);
  store(packet.t_far + at, Float<L>(kShadowEnd));
}

/// Counts the shadow rays that are about to be traced.
inline void count_shadow_rays(Wave& wave) {
  Stats& stats = wave.stats;
  stats.rays.shadow += static_cast<std::uint64_t>(wave.shadow_count);
  const std::uint32_t* const light = wave.shadows.columns().light;
  for (int i = 0; i < wave.shadow_count; ++i)
    if (light[i] < stats.lights.size()) ++stats.lights[light[i]].rays;
}

/// Counts what a shadow ray has brought from a light.
SHEAF_INLINE void count_arrival(Wave& wave, std::uint32_t light, Quad found) {
  if (light >= wave.stats.lights.size()) return;
  LightStats& stats = wave.stats.lights[light];
  ++stats.arrived;
  stats.radiance += static_cast<double>(found[0] + found[1] + found[2] + found[3]);
}

}  // namespace sheaf
