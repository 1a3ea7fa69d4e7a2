// Stage: shadow. Asks Embree whether anything lies between a vertex and its sampled light, sixteen rays at a time.
#include "kernels/stage_timer.h"
#include "kernels/stages.h"

namespace sheaf {

namespace {

/// Shadow rays end this close to the light's point, which itself lies off the light's surface, so that rounding of the
/// direction cannot carry them into it.
constexpr float kShadowEnd = 1.0f - 4.0f * 5.9604645e-8f;

template <class L> SHEAF_INLINE void pack(const Wave& wave, int i, RayPacket& packet, int at) {
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

/// Adds the contribution of item `i` to its path.
SHEAF_INLINE void pay(Wave& wave, int i) {
  const ShadowItem<Columns>& c = wave.shadows.columns();
  float* radiance = wave.radiance.row(static_cast<Slot>(c.slot[i]));
  radiance[0] += c.contribution.c0[i];
  radiance[1] += c.contribution.c1[i];
  radiance[2] += c.contribution.c2[i];
  radiance[3] += c.contribution.c3[i];
}

}  // namespace

template <class L> void shadow(const SceneView& scene, Wave& wave) noexcept {
  const int rays = wave.shadow_count;
  if (rays == 0) return;
  StageTimer timer(wave.stats, Stage::kShadow);
  timer.count(rays, kPacketWidth);
  wave.stats.rays.shadow += static_cast<std::uint64_t>(rays);
  RayPacket packet;
  for (int first = 0; first < rays; first += kPacketWidth) {
    const int in_packet = std::min(kPacketWidth, rays - first);
    for_tiles<L>(in_packet, [&](int at, int) { pack<L>(wave, first + at, packet, at); });
    if (wave.recorder) wave.recorder->record(packet, in_packet, RayRecorder::Query::kAny);
    const std::uint64_t start = timestamp();
    scene.accel->occluded(packet, in_packet);
    wave.stats.trace_ticks += timestamp() - start;
    for (int i = 0; i < in_packet; ++i)
      if (packet.t_far[i] >= 0.0f) pay(wave, first + i);
  }
  wave.shadow_count = 0;
}

SHEAF_INSTANTIATE_STAGE(shadow);

}  // namespace sheaf
