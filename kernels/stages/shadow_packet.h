// Shadow rays in the packet format of Embree, and their statistics; shared by the shadow and transmittance stages.
#pragma once

#include "core/color/float4.h"
#include "kernels/wave/path_time.h"

namespace sheaf {

/// Maximum t of shadow rays, slightly before the point on the light, which itself lies off the light's surface. So
/// rounding errors of the direction cannot make the ray hit the light.
inline constexpr float kShadowEnd = 1.0f - 4.0f * 5.9604645e-8f;

/// Copies the shadow rays [i, i + L::width) to lanes of the packet, from `at` on.
template <class L>
SHEAF_INLINE void pack_shadow_rays(const SceneView& scene, const Wave& wave, int i, RayPacket& packet, int at) {
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
  if (!scene.motion.any()) return;
  for (int lane = 0; lane < L::width; ++lane)
    packet.time[at + lane] = path_time(scene, wave, static_cast<Slot>(c.slot[i + lane]));
}

/// Counts the shadow rays of each light and their contributions. The counts of consecutive rays to the same light are
/// kept locally and added once.
class LightCounter {
 public:
  explicit LightCounter(Stats& stats) : stats_(stats) {}
  ~LightCounter() { flush_counts(); }
  LightCounter(const LightCounter&) = delete;
  LightCounter& operator=(const LightCounter&) = delete;

  /// Counts a shadow ray that will be traced.
  SHEAF_INLINE void spend(std::uint32_t light) {
    transpose_to(light);
    ++counted_.rays;
  }
  /// Counts a shadow ray that is unoccluded.
  SHEAF_INLINE void arrive(std::uint32_t light, const Spectrum4& found) {
    transpose_to(light);
    ++counted_.arrived;
    counted_.radiance += static_cast<double>((found.c0 + found.c1) + (found.c2 + found.c3));
  }

 private:
  SHEAF_INLINE void transpose_to(std::uint32_t light) {
    if (light == light_) [[likely]]
      return;
    flush_counts();
    light_ = light;
    counted_ = {};
  }
  void flush_counts() {
    if (light_ < stats_.lights.size()) stats_.lights[light_] += counted_;
  }

  Stats& stats_;
  std::uint32_t light_ = kNone;
  LightStats counted_;
};

/// Counts the shadow rays of the wave, before they are traced.
inline void count_shadow_rays(Wave& wave) {
  wave.stats.rays.shadow += static_cast<std::uint64_t>(wave.shadow_count);
  LightCounter tally(wave.stats);
  const std::uint32_t* const light = wave.shadows.columns().light;
  for (int i = 0; i < wave.shadow_count; ++i) tally.spend(light[i]);
}

}  // namespace sheaf
