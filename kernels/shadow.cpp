// Stage: shadow. Asks Embree whether anything lies between a vertex and its sampled light, sixteen rays at a time.
#include "kernels/shadow_packet.h"
#include "kernels/stage_timer.h"
#include "kernels/stages.h"

namespace sheaf {

namespace {

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
    for_tiles<L>(in_packet, [&](int at, int) { pack_shadow_rays<L>(wave, first + at, packet, at); });
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
