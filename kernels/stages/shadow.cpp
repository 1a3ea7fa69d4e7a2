// Stage: shadow. Traces shadow rays between vertices and sampled lights with Embree, sixteen at a time, and adds the
// unoccluded contributions.
#include "core/soa/lane_array.h"
#include "kernels/stages/candidate_moments.h"
#include "kernels/stages/shadow_packet.h"
#include "kernels/stages/stage_list.h"
#include "kernels/stages/trace_packets.h"
#include "kernels/wave/add_radiance.h"
#include "kernels/wave/stage_timer.h"

namespace sheaf {

namespace {

/// Adds the contribution of item `i` to its path.
SHEAF_INLINE void add_unoccluded(const StageContext& context, Wave& wave, int i, LightCounter& tally) {
  const ShadowItem<Columns>& c = wave.shadows.columns();
  const Spectrum4 found{c.contribution.c0[i], c.contribution.c1[i], c.contribution.c2[i], c.contribution.c3[i]};
  tally.arrive(c.light[i], found);
  if (context.compares_candidates()) [[unlikely]]
    add_unoccluded_moments(wave, static_cast<Slot>(c.slot[i]), total<Scalar>(found));
  add_radiance(wave, static_cast<Slot>(c.slot[i]), Float4(found), c.light[i], 1);
}

}  // namespace

template <class L> void shadow(const StageContext& context, Wave& wave) noexcept {
  const int rays = wave.shadow_count;
  if (rays == 0) return;
  StageTimer timer(wave.stats, stage_named<L>("shadow"));
  timer.count(rays, kPacketWidth);
  count_shadow_rays(wave);
  LightCounter tally(wave.stats);
  trace_packets(
      context.scene, wave, rays, RayRecorder::Query::kAny,
      [&](int first, int count, RayPacket& packet) {
        for_tiles<L>(count, [&](int at, int) { pack_shadow_rays<L>(context.scene, wave, first + at, packet, at); });
      },
      [&](int first, int count, const RayPacket& packet) {
        std::uint32_t arrived = 0;
        for_tiles<L>(count, [&](int at, int lanes) {
          Float<L> t_far;
          load(packet.t_far + at, t_far);
          arrived |= mask_bits((t_far >= Float<L>(0.0f)) & L::first(lanes)) << at;
        });
        for_each_lane(arrived, [&](int i) SHEAF_LAMBDA_INLINE { add_unoccluded(context, wave, first + i, tally); });
      });
  wave.shadow_count = 0;
}

SHEAF_INSTANTIATE_STAGE(shadow);

}  // namespace sheaf
